//! Every model on every scene with an exact answer: error bar, true error, seconds.

mod scenes;

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

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
    /// The result, or the reason why the model does not treat the scene.
    result: Result<Measured, String>,
}

/// Result of a model.
#[derive(Clone, Debug)]
struct Measured {
    /// The model that was used, for `auto` with the reason of the choice.
    used: String,
    /// Error bar, relative to the exact value.
    bar: f64,
    /// Whether an estimated discretisation error was subtracted.
    is_corrected: bool,
    /// True error, relative to the exact value.
    error: f64,
    seconds: f64,
}

/// Models with their tolerances.
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
/// A model whose true error is larger than its error bar allows.
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
    let violated: Vec<&Row> = rows.iter().filter(|row| !row.holds()).collect();
    if !violated.is_empty() {
        let lines: Vec<String> = violated.into_iter().map(line).collect();
        bail!(
            "errors are larger than their bars allow:\n{}",
            lines.join("\n")
        );
    }
    Ok(())
}

impl Row {
    /// Whether the error bar holds.
    ///
    /// Bars are upper bounds to six digits: those of simpler models are nearly exact. Those of
    /// corrected values are estimates, which hold to a factor of two. Errors up to 1e-12 are
    /// rounding errors.
    fn holds(&self) -> bool {
        match &self.result {
            Ok(m) => {
                let bars = if m.is_corrected { 2.0 } else { 1.0 + 1e-6 };
                m.error <= bars * m.bar + 1e-12
            }
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
    let clock = Instant::now();
    let mut choice = choose(&scene).map_err(SwimError::from)?;
    let answer = answer(&scene, case.exact, choice.model.as_mut())?;
    let size = answer.exact.norm();
    let used = match (model, choice.reasons.last()) {
        // The rest of the sentence says why, at length.
        ("auto", Some(reason)) => reason
            .split(", the cheapest")
            .next()
            .unwrap_or("")
            .to_owned(),
        _ => choice.model.name().to_owned(),
    };
    Ok(Measured {
        used,
        bar: answer.bar / size,
        is_corrected: answer.is_corrected,
        error: (answer.found - answer.exact).norm() / size,
        seconds: clock.elapsed().as_secs_f64(),
    })
}

/// Answer of a model to a scene.
struct Answer {
    found: Vector3<f64>,
    bar: f64,
    /// Whether an estimated discretisation error was subtracted.
    is_corrected: bool,
    exact: Vector3<f64>,
}

fn answer(
    scene: &Scene,
    exact: Exact,
    model: &mut dyn swimmer::models::Hydrodynamics,
) -> Result<Answer, SwimError> {
    match exact {
        Exact::Velocity(exact) => {
            let instant = solve_start(scene, model)?;
            Ok(Answer {
                found: instant.bodies[0].velocity,
                bar: instant.error_estimate.total(),
                is_corrected: instant.mesh_error.is_some(),
                exact,
            })
        }
        Exact::Net(exact) => {
            let outcome = simulate(scene, model, Method::Collocation, &mut ())?;
            let bodies = outcome.displacement.len() as f64;
            Ok(Answer {
                found: outcome.displacement.iter().sum::<Vector3<f64>>() / bodies,
                bar: outcome.error_estimate.total(),
                is_corrected: outcome.mesh_error.is_some(),
                exact,
            })
        }
    }
}

fn line(row: &Row) -> String {
    match &row.result {
        Ok(m) => format!(
            "| {} | {} | {} | {:.1e} | {:.1e} | {:.4} |",
            row.scene, row.model, m.used, m.bar, m.error, m.seconds
        ),
        Err(reason) => {
            // The message begins with a place in the generated scene, which readers do not see.
            let reason = reason.rsplit(": ").next().unwrap_or(reason);
            format!("| {} | {} | {reason} | | | |", row.scene, row.model)
        }
    }
}

fn markdown(rows: &[Row]) -> Result<String> {
    let mut text = format!(
        "# Models\n\n{}, {}. Made by `cargo xtask models`. Every model on every scene with an exact solution: velocity of the first body, or net \
         displacement of the stroke; the error bar that the model gives and its true error, both relative to the exact value; seconds from \
         the scene to the result, for `auto` including the choice. The number behind a model is `model.tolerance`.\n\n\
         Models without a mesh add up the error bars of all solves of a stroke; the errors of its legs mostly cancel. Elements subtract \
         their estimated discretisation error; their bars, for what is left of it, hold to a factor of two.\n\n\
         | scene | model | used | bar | error | seconds |\n|:--|:--|:--|--:|--:|--:|\n",
        machine::today(),
        machine::processor()
    );
    for row in rows {
        writeln!(text, "{}", line(row))?;
    }
    Ok(text)
}

fn csv(rows: &[Row]) -> Result<String> {
    let mut text = String::from("scene,model,used,bar,error,seconds\n");
    let plain = |s: &str| s.replace(',', ";").replace('\n', " ");
    for row in rows {
        let start = format!("{},{}", plain(&row.scene), plain(&row.model));
        match &row.result {
            Ok(m) => writeln!(
                text,
                "{start},{},{:e},{:e},{:.5}",
                plain(&m.used),
                m.bar,
                m.error,
                m.seconds
            )?,
            Err(reason) => writeln!(text, "{start},refused: {},,,", plain(reason))?,
        }
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "a minute"]
    fn all_bars_of_the_quick_table_hold() {
        run(true, &std::env::temp_dir().join("models-quick")).unwrap();
    }

    #[test]
    fn errors_of_the_automatic_choice_are_below_bar_and_tolerance() {
        for case in scenes::all() {
            // A swimmer that moves in space takes seconds per tolerance; the command computes the
            // whole table.
            let tolerances: &[f64] = match case.name.contains("swimmer") {
                true => &[1e-3],
                false => &[1e-2, 1e-4, 1e-7],
            };
            for &tolerance in tolerances {
                let row = row(&case, "auto", tolerance);
                let measured = row.result.as_ref().unwrap();
                assert!(row.holds(), "{}", line(&row));
                assert!(!measured.used.contains(','), "{}", measured.used);
                assert!(measured.error <= tolerance, "{tolerance:e}: {}", line(&row));
            }
        }
    }
}
