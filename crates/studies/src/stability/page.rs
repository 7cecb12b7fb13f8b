//! The map as one HTML page that needs nothing else.

use anyhow::Result;

use super::Everything;
use super::integration::chart;
use super::map::Tried;
use super::picture;
use crate::machine;
use crate::page::{Part, html as page};

/// The page.
pub fn html(everything: &Everything) -> Result<String> {
    let cells = || everything.maps.iter().flat_map(|map| map.cells());
    let count = |word: &str| cells().filter(|cell| cell.outcome.word() == word).count();
    let mut parts = vec![
        Part::Text(format!(
            "{}, {}; {:.0} s. Made by cargo xtask stability. Every known way to fail is tried with every way to compute it: each must end in the right answer \
             or in a refusal that says why.",
            machine::today(),
            machine::processor(),
            everything.seconds
        )),
        Part::Figures(vec![
            (everything.hardships().to_string(), "hardships".into()),
            (everything.cells().to_string(), "cells".into()),
            (
                count("right").to_string(),
                "right, of the maps' cells".into(),
            ),
            (count("refused").to_string(), "refused with a reason".into()),
            (everything.wrong().to_string(), "Wrong answers".into()),
        ]),
    ];
    for map in &everything.maps {
        parts.push(Part::Heading(map.title.into()));
        parts.push(Part::Text(map.note.into()));
        parts.push(Part::Chart(picture::svg(map)));
        let reasons = map.reasons();
        if !reasons.is_empty() {
            parts.push(Part::Table {
                heads: vec!["refused".into(), "reason given".into()],
                rows: reasons
                    .into_iter()
                    .map(|(message, hardship)| (vec![hardship.into(), message.into()], false))
                    .collect(),
            });
        }
    }
    parts.push(Part::Heading("Integrators".into()));
    parts.push(tried(&everything.integrators.tried));
    let (scallop, stroke) = charts(everything)?;
    parts.extend([Part::Chart(scallop), Part::Chart(stroke)]);
    parts.push(Part::Heading("Algebra".into()));
    parts.push(tried(&everything.algebra));
    Ok(page("The stability map", &parts))
}

/// The two charts of the integrators.
pub fn charts(everything: &Everything) -> Result<(String, String)> {
    let study = &everything.integrators;
    Ok((
        chart(
            "Scallop drift: one arm closes and opens, and nothing should have moved",
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
        heads: vec!["tried".into(), "came to".into()],
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
