//! J: hinges, springs and flows: Purcell's swimmer, elastic arms and Jeffery orbits.

use std::f64::consts::{PI, TAU};
use std::time::Instant;

use anyhow::{Context, Result};
use swimmer::{Method, Outcome, Scene, choose, simulate, with_tables};

use super::row::{Basis, Cost, Estimated, Row};
use crate::reference::{ELASTIC_ARMS, PURCELL};

/// Tolerance of the elastic arms.
const PROMISED_TOLERANCE: f64 = 1e-6;

/// Required: the default tolerance of a stroke.
const REQUIRED_ACCURACY: f64 = 1e-3;

/// Required of half a Jeffery orbit: a thousandth of a turn, relative to half a turn.
const REQUIRED_TURN: f64 = 2e-3;

/// All rows; Purcell's swimmer, a minute, and spheroids that tumble are not in the quick part.
pub fn rows(quick: bool) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (amplitude, frequency, exact) in ELASTIC_ARMS {
        // 0.0714303722 is k / G22 for the stiffness k = 1 of the template.
        let (outcome, cost) = run(
            include_str!("../../../swimmer/templates/elastic-arm.toml"),
            &[
                format!("gait.period={:?}", TAU / (0.071_430_372_2 * frequency)),
                format!("gait.harmonics.0.amplitude={amplitude:?}"),
                "model.kind=multipole".to_owned(),
                format!("model.tolerance={PROMISED_TOLERANCE:?}"),
            ],
        )?;
        let name = format!("elastic arm, amplitude {amplitude}, frequency {frequency}: net");
        let values = [exact, outcome.displacement[0].x];
        let row = Row::relative(
            "J",
            name,
            values,
            (PROMISED_TOLERANCE, Basis::Promised),
            cost,
        );
        rows.push(row.with(Estimated::bound(outcome.error_estimate.total())));
    }
    if quick {
        return Ok(rows);
    }
    for ratio in [2.0, 10.0] {
        // Jeffery 1922: half of the period 2 pi (r + 1 / r) at the shear rate 1.
        let (outcome, cost) = run(
            include_str!("../../../swimmer/templates/jeffery.toml"),
            &[
                format!("bodies.spheroid.half_length={ratio:?}"),
                format!("gait.phases.0.duration={:?}", PI * (ratio + 1.0 / ratio)),
            ],
        )?;
        let name = format!("Jeffery orbit, aspect ratio {ratio}: half a turn");
        let values = [PI, outcome.rotation.norm()];
        let required = (REQUIRED_TURN, Basis::Required);
        rows.push(Row::relative("J", name, values, required, cost));
    }
    let text = include_str!("../../../swimmer/templates/purcell.toml");
    let (outcome, cost) = run(text, &[])?;
    let net_bar = outcome.error_estimate.total();
    for (name, exact, found, bar) in [
        ("net", PURCELL.net, outcome.displacement[1].x, net_bar),
        (
            "work",
            PURCELL.work,
            outcome.work,
            outcome.work_error.total(),
        ),
    ] {
        let name = format!("Purcell's swimmer of spheroids, 30 degrees: {name}");
        let row = Row::relative(
            "J",
            name,
            [exact, found],
            (REQUIRED_ACCURACY, Basis::Required),
            cost,
        );
        let row = row.with(Estimated::bound(bar));
        rows.push(row.with_exact_bar(PURCELL.accuracy));
    }
    Ok(rows)
}

fn run(text: &str, overrides: &[String]) -> Result<(Outcome, Cost)> {
    let clock = Instant::now();
    let mut document = swimmer::scene::Document::parse(text, "template.toml")?;
    overrides
        .iter()
        .try_for_each(|assignment| document.set(assignment))?;
    let scene = Scene::from_document(document)?;
    let mut model = with_tables(&scene, choose(&scene)?)?.model;
    let method = Method::from_scene(&scene);
    let outcome =
        simulate(&scene, model.as_mut(), method, &mut ()).context("a gait with joints")?;
    let cost = Cost {
        seconds: clock.elapsed().as_secs_f64(),
        ..Cost::default()
    };
    Ok((outcome, cost))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elastic_arms_are_exact() {
        for row in rows(true).unwrap() {
            assert!(row.passes(), "{row:?}");
        }
    }
}
