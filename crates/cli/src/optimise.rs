//! `swim optimise`: the best stroke.

use std::path::Path;

use design::{
    BestWave, DesignedStroke, StrokeCurve, StrokeTotals, best_wave, design_stroke, gait_shapes,
    wave_variables,
};
use serde_json::{Value, json};
use swimmer::scene::ObjectiveKind;
use swimmer::{Efficiency, Scene};

use super::arguments::DesignArguments;
use super::design_files::{
    folder_of, gait_entries, table_entries, table_warning, write, write_map,
};
use super::error::CliError;
use super::progress::DesignSpinner;
use super::text::{
    NO_ESTIMATE, count, duration, entry, measured, percent, printable, rotation_entry, two_digits,
    warn, with_bar,
};

pub fn optimise(arguments: DesignArguments, quiet: bool) -> Result<String, CliError> {
    let DesignArguments { scene, out, json } = arguments;
    let scene = scene.read(quiet)?;
    let clock = std::time::Instant::now();
    let (folder, _lock) = folder_of(&scene, out)?;
    let waves = wave_variables(&scene)?;
    if !waves.is_empty() {
        let mut spinner = DesignSpinner::new(quiet);
        let found = best_wave(&scene, &waves, folder.path(), &mut spinner)?;
        let answer = found.json();
        write(&folder, "optimum.json", &format!("{answer:#}\n"))?;
        return Ok(match json {
            true => format!("{answer}\n"),
            false => describe_wave(&scene, &found, folder.path(), clock.elapsed().as_secs_f64()),
        });
    }
    let found = design_stroke(&scene, folder.path(), &mut DesignSpinner::new(quiet))?;
    let names = found.limits.joint_names(&scene);
    let curve: Vec<Vec<f64>> = (found.shapes.iter())
        .map(|shape| found.limits.moving(shape))
        .collect();
    let geometry = &found.table.geometry;
    write_map(&folder, "optimum.svg", geometry, &names, &curve)?;
    for warning in warnings(&scene, &found) {
        warn(&warning);
    }
    let answer = optimum_json(&found);
    write(&folder, "optimum.json", &format!("{answer:#}\n"))?;
    if json {
        return Ok(format!("{answer}\n"));
    }
    Ok(describe(
        &scene,
        &found,
        &gait_shapes(&scene, &found.limits)?,
        folder.path(),
        clock.elapsed().as_secs_f64(),
    ))
}

fn warnings(scene: &Scene, found: &DesignedStroke) -> Vec<String> {
    let (options, optimum) = (scene.optimise(), &found.optimum);
    let mut warnings: Vec<String> = table_warning(&found.table).into_iter().collect();
    if optimum.refinement_error.is_infinite() {
        warnings.push(
            "how far the stroke is from the optimum is not known without a refinement: increase \
             optimise.terms"
                .to_owned(),
        );
    } else if optimum.refinement_error > options.tolerance {
        warnings.push(format!(
            "optimise.tolerance = {:e} was requested, and the last increase of the number of terms \
             or corners to {} changed the objective by {}; increase optimise.terms",
            options.tolerance,
            optimum.curve.terms(),
            two_digits(optimum.refinement_error),
        ));
    }
    if optimum.at_limits && options.objective != ObjectiveKind::Displacement {
        warnings.push(
            "the optimum touches the limits of the joints: wider limits, or a smaller gap, give a \
             better stroke"
                .to_owned(),
        );
    }
    warnings
}

fn optimum_json(found: &DesignedStroke) -> Value {
    let optimum = &found.optimum;
    json!({
        "displacement": optimum.totals.displacement.norm(),
        "displacement_vector": optimum.totals.displacement.as_slice(),
        "rotation": optimum.totals.rotation.as_slice(),
        "energy": found.energy,
        "period": found.period,
        "displacement_per_time": optimum.totals.displacement.norm() / found.period,
        "max_rate": found.peaks.rates,
        "max_power": found.peaks.power,
        "period_energy_product": optimum.period_energy_product,
        "efficiency": found.efficiency,
        "terms": optimum.curve.terms(),
        "refinement_error": optimum.refinement_error,
        "at_limits": optimum.at_limits,
        "lengths": found.shapes,
        "table": {
            "model": found.table.model,
            "points": found.table.geometry.points(),
            "displacement_error": found.table_error,
            "errors": found.table.geometry.errors(),
            "position_error": found.table.geometry.position_error(),
        },
        "run": {
            "model": found.model,
            "displacement": found.run_displacement,
            "displacement_error": found.outcome.error_estimate.total(),
            "rotation": found.outcome.rotation.as_slice(),
            "energy": found.outcome.work,
            "energy_error": found.outcome.work_error.total(),
            "efficiency": found.run_efficiency.as_ref().map(Efficiency::json),
            "solves": found.outcome.model_solves(),
        },
        "gait": found.gait.map(|(totals, product)| json!({
            "displacement": totals.displacement.norm(),
            "period_energy_product": product,
        })),
    })
}

/// Radius of the circle (of the helix, in space) through the positions after successive cycles: the
/// displacement is its chord for the angle of the rotation.
fn circle(totals: &StrokeTotals) -> f64 {
    let axis = totals.rotation.normalize();
    let across = totals.displacement - axis * axis.dot(&totals.displacement);
    across.norm() / (2.0 * (0.5 * totals.rotation.norm()).sin().abs())
}

fn describe(
    scene: &Scene,
    found: &DesignedStroke,
    gait_shapes: &[Vec<f64>],
    out: &Path,
    seconds: f64,
) -> String {
    let (optimum, table) = (&found.optimum, &found.table);
    let terms = optimum.curve.terms();
    let search = format!(
        "{}, {}, {}",
        count(optimum.starts, "start"),
        count(optimum.iterations, "iteration"),
        match optimum.curve {
            StrokeCurve::Polygon { .. } => count(terms, "corner"),
            StrokeCurve::Series { .. } => format!("{} per joint", count(terms, "term")),
        }
    );
    let gait = found.gait.as_ref();
    let gait = gait.map(|gait| gait_entries(table, gait, gait_shapes));
    entry("scene", scene.name())
        + &entry("objective", scene.optimise().objective.word())
        + &entry("model", found.model)
        + &table_entries(table)
        + &entry("search", search)
        + "\n"
        + &describe_stroke(found)
        + &gait.unwrap_or_default()
        + "\n"
        + &entry("time", duration(seconds))
        + &entry("results", out.join("optimum.toml").display())
}

/// The table and the best wave of a tube.
fn describe_wave(scene: &Scene, found: &BestWave, out: &Path, seconds: f64) -> String {
    let report = &found.report;
    // The words after the name of the body.
    let word = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
    let words: Vec<String> = found.variables.iter().map(|of| word(&of.key)).collect();
    let mut text = entry("scene", scene.name())
        + &entry("objective", scene.optimise().objective.word())
        + &entry("model", report.model)
        + &entry("table", count(found.table.rows.len(), "run"))
        + "\n";
    let cell = |value: &String| match value.parse::<f64>() {
        Ok(value) => format!("{value:<12.4}"),
        Err(_) => printable(value),
    };
    let row = |cells: Vec<String>, rest: &str| {
        let cells: Vec<String> = cells.iter().map(|cell| format!("{cell:<12}")).collect();
        format!("{}{rest}\n", cells.concat())
    };
    text += &row(words.clone(), "Lighthill efficiency, net displacement");
    for of_row in &found.table.rows {
        if let Ok(result) = &of_row.result {
            let efficiency = result.efficiency;
            let efficiency = efficiency.map_or("none".to_owned(), |of| {
                with_bar(of, result.efficiency_error)
            });
            let net = with_bar(result.displacement.norm(), result.displacement_error);
            let cells = of_row.values.iter().map(cell).collect();
            text += &row(cells, &format!("{efficiency}, {net}"));
        }
    }
    text += "\n";
    for (k, word) in words.iter().enumerate() {
        let [low, high] = found.variables[k].range;
        let label = format!("best {word}");
        text += &match found.errors[k] {
            Some(bar) => measured(&label, found.values[k], bar),
            None => entry(
                &label,
                format!("{} (no bar; between {low} and {high})", found.values[k]),
            ),
        };
    }
    let label = scene.optimise().objective.word();
    text += &entry(&format!("{label} by table"), unestimated(found.by_table));
    text += &match found.error {
        Some(bar) => measured("  by its run", found.objective, bar),
        None => entry("  by its run", unestimated(found.objective)),
    };
    text + "\n"
        + &entry("time", duration(seconds))
        + &entry("results", out.join("optimum.toml").display())
}

/// A number without an error bar.
fn unestimated(value: f64) -> String {
    format!("{value:.4e} {NO_ESTIMATE}")
}

/// The motion, the energy and the efficiency of the best stroke.
fn describe_stroke(found: &DesignedStroke) -> String {
    let (optimum, outcome) = (&found.optimum, &found.outcome);
    let (displacement, error) = (optimum.totals.displacement.norm(), found.table_error);
    let (energy, period) = (found.energy, found.period);
    let mut text = measured("displacement by table", displacement, error);
    let bar = outcome.error_estimate.total();
    text += &measured("  by the model", found.run_displacement, bar);
    let rotation = &optimum.totals.rotation;
    if rotation.norm() > 1e-9 {
        let (angle, radius) = (rotation.norm().to_degrees(), circle(&optimum.totals));
        text += &rotation_entry("rotation vector", rotation, 0.0);
        text += &entry(
            "heading",
            format!("turns by {angle:.4} degrees per cycle, on a circle of radius {radius:.4}"),
        );
    }
    let energy = format!("{energy:.6} in a period of {period} {NO_ESTIMATE}");
    text += &entry("energy by table", energy);
    text += &measured("  by the model", outcome.work, outcome.work_error.total());
    text += &measured(
        "displacement per time",
        displacement / period,
        error / period,
    );
    let rates = (found.peaks.rates.iter()).fold(0.0_f64, |largest, rate| largest.max(*rate));
    let (power, product) = (found.peaks.power, optimum.period_energy_product);
    let peaks = format!("{rates:.6}, {power:.6} {NO_ESTIMATE}");
    text += &entry("largest rate, power", peaks);
    let product = format!("{product:.6} at constant power {NO_ESTIMATE}");
    text += &entry("energy times period", product);
    text += &entry("Lighthill efficiency", unestimated(found.efficiency));
    if let Some(of_run) = found.run_efficiency {
        let of_run = with_bar(of_run.value, of_run.error);
        let towed = "with the drag of the towed swimmer, as of swim run, not of lone spheres";
        text += &entry("  by the model", format!("{of_run}, {towed}"));
    }
    let change = match optimum.refinement_error.is_finite() {
        true => {
            let change = percent(optimum.refinement_error);
            format!("changed the objective by {change}")
        }
        false => "none: optimise.terms allows the first terms only".to_owned(),
    };
    text + &entry("last refinement", change)
}
