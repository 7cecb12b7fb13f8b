//! The texts and tables of the page, escaping and templates for HTML.

use models::ErrorEstimate;
use serde_json::Value;

use super::inertia;
use super::record::RunRecord;
use crate::numbers::{
    ANGLE_ROUNDING, count, decimals, duration, open_gait, percent, rounded, significant_vector,
    solve_count, tolerance_statement, two_digits, with_uncertainty,
};

/// One sentence about the run.
pub fn lead(record: &RunRecord) -> String {
    let gait = record.scene.gait();
    let summary = &record.summary;
    let met = match summary["tolerance"].as_f64() {
        Some(tolerance) => format!("; {}", tolerance_statement(&record.outcome, tolerance)),
        None => String::new(),
    };
    let stopped = match &record.outcome.stopped {
        Some(reason) => format!(" Stopped before its end: {}.", escaped(reason)),
        None => String::new(),
    };
    format!(
        "{} of {}, duration {}. Model {}, {}{met}.{stopped}",
        count(gait.cycles as usize, "cycle"),
        count(gait.phases.len(), "phase"),
        gait.duration(),
        escaped(summary["model"].as_str().unwrap_or("unknown")),
        solve_count(&record.outcome),
    )
}

/// Net displacement, work, efficiency and the displacements of the bodies; energies and forces in
/// fluids with inertia.
pub fn results(record: &RunRecord) -> String {
    let outcome = &record.outcome;
    let error = outcome.error_estimate.total();
    let of_rotation = match outcome.rotation_error.total() {
        bar if bar > 0.0 && bar < outcome.rotation.norm() => format!(" +- {bar:.1e}"),
        _ => String::new(),
    };
    let bar = outcome.rotation_error.total();
    let of_rotation =
        significant_vector(outcome.rotation.into(), bar, ANGLE_ROUNDING) + &of_rotation;
    let entries = [
        (
            "Net displacement",
            with_uncertainty(outcome.resolved_net(), error),
            "length",
        ),
        ("Rotation vector", of_rotation, "radians"),
        (
            "Work on the fluid",
            with_uncertainty(outcome.work, outcome.work_error.total()),
            "energy",
        ),
    ];
    let mut html =
        "<table class=\"totals\"><caption>Totals, in the scene's units</caption><tbody>\n"
            .to_owned();
    let efficiency = &record.summary["efficiency"];
    let efficiency = efficiency["value"].as_f64().map(|value| {
        let bar = efficiency["error"].as_f64();
        let text = bar.map_or_else(|| two_digits(value), |bar| with_uncertainty(value, bar));
        ("Lighthill efficiency".to_owned(), text, "")
    });
    let of_inertia = inertia::results(&record.scene, outcome);
    for (label, value, unit) in entries
        .map(|(label, value, unit)| (label.to_owned(), value, unit))
        .into_iter()
        .chain(efficiency)
        .chain(of_inertia)
    {
        let value = value.replace("+-", "±");
        html += &format!(
            "<tr><th scope=\"row\">{}</th><td class=\"number\">{value}</td><td>{unit}</td></tr>\n",
            escaped(&label)
        );
    }
    if let Some(words) = open_gait(&record.scene, outcome) {
        for (label, words) in ["Shape", "Rigid part"].into_iter().zip(words) {
            let words = escaped(&words);
            html +=
                &format!("<tr><th scope=\"row\">{label}</th><td colspan=\"2\">{words}</td></tr>\n");
        }
    }
    html += "</tbody></table>\n<div class=\"scroll\" tabindex=\"0\" role=\"group\" \
             aria-label=\"displacements\"><table><caption>Displacement of each body, ± ";
    html += &two_digits(error);
    html += "</caption><thead><tr><th scope=\"col\">Body</th>";
    for axis in ["x", "y", "z"] {
        html += &format!("<th scope=\"col\" class=\"number\">{axis}</th>");
    }
    html += "</tr></thead><tbody>\n";
    let decimals = match error > 0.0 {
        true => decimals(error),
        false => 6,
    };
    for (body, displacement) in record.scene.bodies().iter().zip(&outcome.displacement) {
        let name = escaped(&body.name);
        html += &format!("<tr><th scope=\"row\" class=\"name\">{name}</th>");
        for value in displacement.iter() {
            let value = rounded(*value, decimals);
            html += &format!("<td class=\"number\">{value:.decimals$}</td>");
        }
        html += "</tr>\n";
    }
    html + "</tbody></table></div>\n"
}

/// The error bars of net displacement and work by source, as tables with bars.
pub fn error_budget(record: &RunRecord) -> String {
    let outcome = &record.outcome;
    let table = |of: &str, estimate: &ErrorEstimate, value: f64| {
        let total = estimate.total();
        let share = |error: f64| if total > 0.0 { error / total } else { 0.0 };
        let relative = |error: f64| match value > 0.0 {
            true => percent(error / value),
            false => "-".to_owned(),
        };
        let mut html = format!(
            "<table class=\"budget\"><caption>{of}</caption><thead><tr><th scope=\"col\">Source</th>\
             <th scope=\"col\" class=\"number\">Absolute</th><th scope=\"col\" \
             class=\"number\">Relative</th><th scope=\"col\">Share of the sum</th></tr></thead>\
             <tbody>\n"
        );
        for (source, error) in estimate.sources() {
            let cells = match error {
                Some(error) => format!(
                    "<td class=\"number\">{}</td><td class=\"number\">{}</td><td><span \
                     class=\"bar\" style=\"--share:{:.4}\"><span \
                     class=\"hidden\">{:.0} %</span></span></td>",
                    two_digits(error),
                    relative(error),
                    share(error),
                    100.0 * share(error)
                ),
                None => "<td class=\"number\" colspan=\"2\">not estimated</td><td></td>".to_owned(),
            };
            html += &format!("<tr><th scope=\"row\">{source}</th>{cells}</tr>\n");
        }
        html += &format!(
            "<tr class=\"sum\"><th scope=\"row\">sum</th><td class=\"number\">{}</td><td \
             class=\"number\">{}</td><td></td></tr></tbody></table>\n",
            two_digits(total),
            relative(total)
        );
        html
    };
    table("Net displacement", &outcome.error_estimate, outcome.net())
        + &table("Work on the fluid", &outcome.work_error, outcome.work.abs())
}

/// Model, time, memory and machine.
pub fn cost(record: &RunRecord) -> String {
    let summary = &record.summary;
    let seconds = |key: &str| summary["seconds"][key].as_f64().filter(|s| *s > 0.0);
    let mut entries: Vec<(String, String)> = Vec::new();
    let reasons = summary["reasons"].as_array().map_or(&[][..], Vec::as_slice);
    let reasons: Vec<&str> = reasons.iter().filter_map(Value::as_str).collect();
    let text = |value: &Value| value.as_str().map(escaped);
    entries.push(("Model".into(), text(&summary["model"]).unwrap_or_default()));
    if !reasons.is_empty() {
        entries.push(("Why this model".into(), escaped(&reasons.join("; "))));
    }
    entries.push(("Solves".into(), solve_count(&record.outcome)));
    if !record.outcome.meshes.is_empty() {
        let meshes = record.outcome.meshes.len();
        entries.push(("Meshes generated".into(), meshes.to_string()));
    }
    if let Some(total) = seconds("total") {
        entries.push(("Time of the run".into(), duration(total)));
    }
    let parts: Vec<String> = ["mesh", "assembly", "setup", "solve", "estimate"]
        .into_iter()
        .filter_map(|part| Some(format!("{part} {}", duration(seconds(part)?))))
        .collect();
    if !parts.is_empty() {
        entries.push(("Parts of it".into(), parts.join(", ")));
    }
    if let Some(mib) = summary["peak_rss_mib"].as_f64() {
        entries.push(("Peak memory".into(), format!("{mib:.0} MiB")));
    }
    for (label, key) in [("Machine", "machine"), ("Version", "version")] {
        if let Some(value) = text(&summary[key]) {
            entries.push((label.into(), value));
        }
    }
    let rows = entries
        .into_iter()
        .map(|(label, value)| format!("<tr><th scope=\"row\">{label}</th><td>{value}</td></tr>\n"));
    format!(
        "<table><tbody>\n{}</tbody></table>\n",
        rows.collect::<String>()
    )
}

/// A text in which the special characters of HTML are escaped.
pub fn escaped(text: &str) -> String {
    let mut html = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => html.push_str("&amp;"),
            '<' => html.push_str("&lt;"),
            '>' => html.push_str("&gt;"),
            '"' => html.push_str("&quot;"),
            other => html.push(other),
        }
    }
    html
}

/// JSON for a script element, with every `<` escaped: `</script` would end the element.
pub fn for_script(json: &str) -> String {
    json.replace('<', "\\u003c")
}

/// A template with every `{{name}}` replaced by its part; the parts are not searched for names.
pub fn filled(template: &str, parts: &[(&str, String)]) -> String {
    let mut html = String::new();
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        html.push_str(before);
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        let part = parts.iter().find(|(known, _)| *known == name);
        html.push_str(part.map_or("", |(_, text)| text));
        rest = after;
    }
    html + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_markup_stay_text_and_parts_are_not_filled_again() {
        assert_eq!(escaped("<a&\"b\">"), "&lt;a&amp;&quot;b&quot;&gt;");
        assert_eq!(for_script("\"</script>\""), "\"\\u003c/script>\"");
        let parts = [("a", "{{b}}".to_owned()), ("b", "2".to_owned())];
        assert_eq!(filled("{{a}} and {{b}}{{c}}.", &parts), "{{b}} and 2.");
    }
}
