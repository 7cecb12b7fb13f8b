//! J: hinges, springs and flows: Purcell's swimmer, elastic arms and Jeffery orbits.

use std::f64::consts::{PI, TAU};
use std::time::Instant;

use anyhow::{Context, Result};
use swimmer::{Method, Outcome, Scene, choose, simulate, with_tables};

use super::effort::Effort;
use super::estimated::Estimated;
use super::row::{Basis, Cost, Row};

/// Tolerance of the elastic arms.
const PROMISED: f64 = 1e-6;

/// Required: the default tolerance of a stroke.
const REQUIRED: f64 = 1e-3;

/// Displacement per cycle of three spheres with one driven and one elastic arm of length 10, for an
/// amplitude and a frequency over `k / G22`: exact multipoles, harmonic balance with 64 points.
const ELASTIC_ARMS: [(f64, f64, f64); 4] = [
    (1.0, 0.1, 0.000_866_135_0),
    (1.0, 1.0, 0.004_376_372_2),
    (1.0, 10.0, 0.000_867_111_2),
    (4.0, 1.0, 0.074_714_864_8),
];

/// Required of half a Jeffery orbit: a thousandth of a turn, relative to half a turn.
const REQUIRED_TURN: f64 = 2e-3;

/// All rows; Purcell's swimmer, a minute, and spheroids that tumble only with full effort.
pub fn rows(effort: Effort) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (amplitude, frequency, exact) in ELASTIC_ARMS {
        // 0.0714303722 is k / G22 for the stiffness k = 1 of the template.
        let (outcome, cost) = run(
            include_str!("../../../swimmer/templates/elastic-arm.toml"),
            &[
                format!("gait.period={:?}", TAU / (0.071_430_372_2 * frequency)),
                format!("gait.harmonics.0.amplitude={amplitude:?}"),
                "model.kind=multipole".to_owned(),
                format!("model.tolerance={PROMISED:?}"),
            ],
        )?;
        rows.push(
            Row::relative(
                "J",
                format!("elastic arm, amplitude {amplitude}, frequency {frequency}: net"),
                [exact, outcome.displacement[0].x],
                (PROMISED, Basis::Promised),
                cost,
            )
            .with(Some(Estimated::bound(outcome.error_estimate.total()))),
        );
    }
    // The tests of `swimmer` have the first one.
    let ratios: &[f64] = match effort {
        Effort::Full => &[2.0, 10.0],
        Effort::Quick => &[],
    };
    for ratio in ratios {
        let text = include_str!("../../../swimmer/templates/jeffery.toml");
        // Jeffery 1922: half of the period 2 pi (r + 1 / r) at the shear rate 1.
        let (outcome, cost) = run(
            text,
            &[
                format!("bodies.spheroid.half_length={ratio:?}"),
                format!("gait.phases.0.duration={:?}", PI * (ratio + 1.0 / ratio)),
            ],
        )?;
        let name = format!("Jeffery orbit, aspect ratio {ratio}: half a turn");
        let exact_and_found = [PI, outcome.rotation.norm()];
        let required = (REQUIRED_TURN, Basis::Required);
        rows.push(Row::relative("J", name, exact_and_found, required, cost));
    }
    if effort == Effort::Full {
        let text = include_str!("../../../swimmer/templates/purcell.toml");
        let (outcome, cost) = run(text, &[])?;
        // Three spheroids 2:1, by the method of fundamental solutions on three levels.
        for (name, exact, found, bar) in [
            (
                "net",
                -0.074_667,
                outcome.displacement[1].x,
                outcome.error_estimate.total(),
            ),
            ("work", 439.603, outcome.work, outcome.work_error.total()),
        ] {
            let name = format!("Purcell's swimmer of spheroids, 30 degrees: {name}");
            let row = Row::relative("J", name, [exact, found], (REQUIRED, Basis::Required), cost);
            rows.push(row.with(Some(Estimated::bound(bar))).with_exact_bar(1.4e-5));
        }
    }
    Ok(rows)
}

fn run(text: &str, overrides: &[String]) -> Result<(Outcome, Cost)> {
    let clock = Instant::now();
    let mut document = swimmer::scene::Document::parse(text, "template.toml".as_ref())?;
    overrides
        .iter()
        .try_for_each(|assignment| document.set(assignment))?;
    let scene = Scene::from_document(document)?;
    let mut model = with_tables(&scene, choose(&scene)?)?.model;
    let method = Method::of(&scene);
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
        for row in rows(Effort::Quick).unwrap() {
            assert!(row.passes(), "{row:?}");
        }
    }
}
