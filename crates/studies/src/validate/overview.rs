//! The validation as one HTML page.

use anyhow::Result;

use super::row::Row;
use super::table::{self, HEADINGS};
use crate::accuracy::Quantity;
use crate::chart::{LogLog, Series, Style};
use crate::machine;
use crate::page::{Part, html};

/// Names of the cases, in the order of the page.
const CASES: [(&str, &str); 8] = [
    ("A", "one sphere in a concentric ball, and spheroids"),
    ("B", "two spheres"),
    ("D", "collinear spheres in a ball"),
    ("E", "the three-sphere swimmer"),
    ("H", "one sphere in a cylinder"),
    ("J", "hinges, springs and flows"),
    ("K", "bodies of other shapes"),
    ("order", "observed orders"),
];

/// The page, and its first chart once more as a separate picture.
pub fn page(rows: &[Row], notes: &[String], quantities: &[Quantity]) -> Result<(String, String)> {
    let chart = errors(rows).svg()?;
    let failed = rows.iter().filter(|row| !row.passes()).count();
    let seconds: f64 = rows.iter().map(|row| row.cost.seconds).fold(0.0, f64::max);
    let largest = rows.iter().map(|row| row.cost.dofs).max().unwrap_or(0);
    let figure = |value: String, caption: &str| (value, caption.to_owned());
    let mut parts = vec![
        Part::Text(format!(
            "Computed values against exact ones: spectral solutions and closed forms, none from a finite-element code. {}, {}.",
            machine::today(),
            machine::processor()
        )),
        Part::Figures(vec![
            figure(
                format!("{} of {}", rows.len() - failed, rows.len()),
                "rows within their tolerance",
            ),
            figure(format!("{largest}"), "dofs in the largest solve"),
            figure(format!("{seconds:.1} s"), "longest row"),
        ]),
        Part::Heading("Errors against seconds".into()),
        Part::Chart(chart.clone()),
    ];
    for (group, name) in groups(rows) {
        let of_group: Vec<&Row> = rows.iter().filter(|row| row.group == group).collect();
        parts.push(Part::Heading(name));
        parts.push(Part::Table {
            heads: HEADINGS[1..].iter().map(|h| (*h).to_owned()).collect(),
            rows: of_group
                .iter()
                .map(|row| (row.cells()[1..].to_vec(), !row.passes()))
                .collect(),
        });
    }
    parts.push(Part::Heading("Where the tolerances come from".into()));
    let lines = table::basis_notes(rows).into_iter().chain(notes.to_vec());
    parts.extend(lines.map(Part::Text));
    for quantity in quantities {
        parts.push(Part::Heading(quantity.title.clone()));
        parts.push(Part::Chart(quantity.chart("seconds", |p| p.seconds).svg()?));
        parts.push(Part::Chart(
            quantity.chart("dofs", |p| p.dofs as f64).svg()?,
        ));
    }
    Ok((html("Validation", &parts), chart))
}

/// Cases that occur, with their names; cases that are not in [`CASES`] come last.
fn groups(rows: &[Row]) -> Vec<(&'static str, String)> {
    let mut groups: Vec<(&str, String)> = CASES
        .iter()
        .filter(|(group, _)| rows.iter().any(|row| row.group == *group))
        .map(|&(group, name)| (group, format!("{group}: {name}")))
        .collect();
    for row in rows {
        if !groups.iter().any(|(group, _)| *group == row.group) {
            groups.push((row.group, row.group.to_owned()));
        }
    }
    groups
}

fn errors(rows: &[Row]) -> LogLog {
    LogLog {
        title: "error of every row over its seconds".into(),
        x: "seconds".into(),
        y: "error".into(),
        series: groups(rows)
            .into_iter()
            // Orders of convergence have no relative error.
            .filter(|(group, _)| *group != "order")
            .map(|(group, name)| Series {
                name,
                points: rows
                    .iter()
                    .filter(|row| row.group == group)
                    .map(|row| (row.cost.seconds, row.error.abs()))
                    .collect(),
                style: Style::Points,
            })
            .collect(),
    }
}
