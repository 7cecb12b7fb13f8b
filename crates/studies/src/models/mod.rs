//! Every model on every scene with an exact answer: the error it claims, the error it makes, seconds.

mod scenes;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant as Clock;

use anyhow::{Result, bail};
use nalgebra::Vector3;
use swimmer::choose;
use swimmer::{Method, Scene, SwimError, simulate, solve_start};

use self::scenes::{Case, Exact};
use crate::{folder, machine};

/// One model on one scene.
pub struct Row {
    scene: String,
    model: String,
    /// What became of it; none where the model does not treat the scene, with the reason.
    result: Result<Measured, String>,
}

/// What a model gave.
#[derive(Clone, Debug)]
struct Measured {
    /// The model that answered, and for `auto` why.
    took: String,
    /// Error bar relative to the exact value.
    claimed: f64,
    /// Error relative to the exact value.
    error: f64,
    seconds: f64,
}

/// A model and the tolerance it is asked for.
const MODELS: &[(&str, f64)] = &[
    ("oseen", 1e-3),
    ("rpy", 1e-3),
    ("multipole", 1e-3),
    ("multipole", 1e-8),
    ("auto", 1e-1),
    ("auto", 1e-2),
    ("auto", 1e-4),
    ("auto", 1e-8),
    ("axisymmetric", 1e-4),
    ("fem", 1e-3),
];

/// Computes the table and writes `models.md` and `models.csv`.
///
/// # Errors
/// A model whose error is above what it claims, except where the table says that it may be.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let mut rows = Vec::new();
    for case in scenes::all() {
        for &(model, tolerance) in MODELS {
            if quick && model == "fem" {
                continue;
            }
            let row = row(&case, model, tolerance);
            eprintln!("{}", line(&row));
            rows.push(row);
        }
    }
    let text = markdown(&rows)?;
    folder::write(out, [("models.md", &text), ("models.csv", &csv(&rows)?)])?;
    let broken: Vec<&Row> = rows.iter().filter(|row| !row.holds()).collect();
    if !broken.is_empty() {
        let lines: Vec<String> = broken.into_iter().map(line).collect();
        bail!("errors above what was claimed:\n{}", lines.join("\n"));
    }
    Ok(())
}

impl Row {
    /// Whether the claim holds, to its sixth digit: lesser models know their error as well as that. A claim below 1e-12 is rounding.
    fn holds(&self) -> bool {
        match &self.result {
            Ok(m) => m.error <= (1.0 + 1e-6) * m.claimed + 1e-12,
            Err(_) => true,
        }
    }
}

fn row(case: &Case, model: &str, tolerance: f64) -> Row {
    let name = match model {
        "oseen" | "rpy" | "fem" => model.to_owned(),
        _ => format!("{model}, {tolerance:.0e}"),
    };
    let measured = measure(case, model, tolerance);
    Row {
        scene: case.name.clone(),
        model: name,
        result: measured.map_err(|error| match error.downcast_ref::<SwimError>() {
            Some(error) => error.to_string(),
            None => format!("{error:#}"),
        }),
    }
}

fn measure(case: &Case, model: &str, tolerance: f64) -> Result<Measured> {
    let scene = case.scene(model, tolerance, "")?;
    let clock = Clock::now();
    let mut choice = choose(&scene).map_err(SwimError::from)?;
    let (found, bar, exact) = answer(&scene, case.exact, choice.model.as_mut())?;
    let took = match (model, choice.reasons.last()) {
        ("auto", Some(reason)) => reason.split(", the least").next().unwrap_or("").to_owned(),
        _ => choice.model.name().to_owned(),
    };
    Ok(Measured {
        took,
        claimed: bar / exact.norm(),
        error: (found - exact).norm() / exact.norm(),
        seconds: clock.elapsed().as_secs_f64(),
    })
}

/// The value of a scene, its error bar, and the exact value.
fn answer(
    scene: &Scene,
    exact: Exact,
    model: &mut dyn swimmer::models::Hydrodynamics,
) -> Result<(Vector3<f64>, f64, Vector3<f64>), SwimError> {
    match exact {
        Exact::Velocity(exact) => {
            let instant = solve_start(scene, model)?;
            let bar = instant.error_estimate.total();
            Ok((instant.bodies[0].velocity, bar, exact))
        }
        Exact::Net(exact) => {
            let outcome = simulate(scene, model, Method::Collocation, &mut ())?;
            let bodies = outcome.displacement.len() as f64;
            let mean = outcome.displacement.iter().sum::<Vector3<f64>>() / bodies;
            Ok((mean, outcome.error_estimate.total(), exact))
        }
    }
}

fn line(row: &Row) -> String {
    match &row.result {
        Ok(m) => format!(
            "| {} | {} | {} | {:.1e} | {:.1e} | {:.4} |",
            row.scene, row.model, m.took, m.claimed, m.error, m.seconds
        ),
        Err(reason) => {
            // the place in a scene that nobody sees says nothing
            let reason = reason.rsplit(": ").next().unwrap_or(reason);
            format!("| {} | {} | {reason} | | | |", row.scene, row.model)
        }
    }
}

fn markdown(rows: &[Row]) -> Result<String> {
    let mut text = format!(
        "# Models\n\n{}, {}. Made by `cargo xtask models`. Every model on every scene with an exact answer: velocity of the first body, or net \
         displacement of the stroke; the error that the model claims with its answer and the error that it makes, both relative to the exact value; seconds from \
         the scene to the answer, of `auto` with the choice. The number behind a model is `model.tolerance`.\n\n\
         Claims for strokes add up what each solve may err by, as if all erred the same way; errors of the legs of a stroke mostly cancel.\n\n\
         | scene | model | took | claimed | error | seconds |\n|:--|:--|:--|--:|--:|--:|\n",
        machine::today(),
        machine::processor()
    );
    for row in rows {
        writeln!(text, "{}", line(row))?;
    }
    Ok(text)
}

fn csv(rows: &[Row]) -> Result<String> {
    let mut text = String::from("scene,model,took,claimed,error,seconds\n");
    let plain = |s: &str| s.replace(',', ";").replace('\n', " ");
    for row in rows {
        let start = format!("{},{}", plain(&row.scene), plain(&row.model));
        match &row.result {
            Ok(m) => writeln!(
                text,
                "{start},{},{:e},{:e},{:.5}",
                plain(&m.took),
                m.claimed,
                m.error,
                m.seconds
            )?,
            Err(reason) => writeln!(text, "{start},not: {},,,", plain(reason))?,
        }
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "a minute"]
    fn no_claim_of_the_quick_table_is_broken() {
        run(true, &std::env::temp_dir().join("models-quick")).unwrap();
    }

    #[test]
    fn what_auto_takes_holds_its_claim_and_the_tolerance() {
        for case in scenes::all() {
            // swimmers in space take seconds a tolerance; the whole table is made by the command
            let tolerances: &[f64] = match case.name.contains("swimmer") {
                true => &[1e-3],
                false => &[1e-1, 1e-2, 1e-4, 1e-7],
            };
            for &tolerance in tolerances {
                let row = row(&case, "auto", tolerance);
                let measured = row.result.as_ref().unwrap();
                assert!(row.holds(), "{}", line(&row));
                assert!(measured.error <= tolerance, "{tolerance:e}: {}", line(&row));
            }
        }
    }
}
