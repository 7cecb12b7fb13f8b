//! The map as one self-contained HTML page.

use anyhow::Result;

use super::integration::chart;
use super::map::Tried;
use super::picture;
use super::results::Results;
use crate::machine;
use crate::page::{Part, html as page};

/// The page.
pub fn html(results: &Results) -> Result<String> {
    let cells = || results.maps.iter().flat_map(|map| map.cells());
    let count = |word: &str| cells().filter(|cell| cell.outcome.word() == word).count();
    let mut parts = vec![
        Part::Text(format!(
            "{}, {}; {:.0} s. Made by cargo xtask stability. Every stress case is computed with every method: each must end in the right solution \
             or in an error with a reason.",
            machine::today(),
            machine::processor(),
            results.seconds
        )),
        Part::Figures(vec![
            (results.stress_cases().to_string(), "stress cases".into()),
            (results.cells().to_string(), "cells".into()),
            (
                count("right").to_string(),
                "right, of the maps' cells".into(),
            ),
            (count("refused").to_string(), "refused with a reason".into()),
            (results.wrong().to_string(), "Wrong answers".into()),
        ]),
    ];
    for map in &results.maps {
        parts.push(Part::Heading(map.title.into()));
        parts.push(Part::Text(map.note.into()));
        parts.push(Part::Chart(picture::svg(map)));
        let reasons = map.reasons();
        if !reasons.is_empty() {
            parts.push(Part::Table {
                heads: vec!["refused".into(), "reason given".into()],
                rows: reasons
                    .into_iter()
                    .map(|(message, case)| (vec![case.into(), message.into()], false))
                    .collect(),
            });
        }
    }
    parts.push(Part::Heading("Integrators".into()));
    parts.push(tried(&results.integrators.tried));
    let (scallop, stroke) = charts(results)?;
    parts.extend([Part::Chart(scallop), Part::Chart(stroke)]);
    parts.push(Part::Heading("Algebra".into()));
    parts.push(tried(&results.algebra));
    Ok(page("The stability map", &parts))
}

/// The two charts of the integrators.
pub fn charts(results: &Results) -> Result<(String, String)> {
    let study = &results.integrators;
    Ok((
        chart(
            "Scallop drift: displacement after one arm closes and opens, exactly zero",
            &study.scallop,
        )
        .svg()?,
        chart(
            "Error of a stroke of four phases that swims and turns",
            &study.stroke,
        )
        .svg()?,
    ))
}

fn tried(list: &[Tried]) -> Part {
    Part::Table {
        heads: vec!["test".into(), "outcome".into()],
        rows: list
            .iter()
            .map(|t| {
                (
                    vec![t.name.clone(), t.outcome.replace('*', "")],
                    !t.as_expected,
                )
            })
            .collect(),
    }
}
