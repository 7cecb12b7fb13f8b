//! The stability map: formulations x solvers x hardships, each cell the right answer or a refusal that says why.

mod algebra;
mod hardships;
mod ilu;
mod report;
mod setup;

use std::path::Path;
use std::time::Instant as Clock;

use anyhow::{Context, Result, bail};
use nalgebra::Vector3;
use swimmer::model::{Instant, choose};
use swimmer::{Scene, SwimError, solve_start};

use hardships::{Expected, Hardship, Truth};
use setup::Setup;

const FORMULATIONS: [&str; 3] = ["p-tilde", "lagrange", "direct-row"];
const SOLVERS: [&str; 4] = ["block", "minres", "schwarz", "direct"];

/// Krylov solvers stop at a true residual of 1e-10. Velocities react to a relative residual `r` with errors up to `r` times
/// the ratio of the largest to the smallest resistance in play: below 1e3 for the scenes here, the closest gap included.
const KRYLOV: f64 = 1e-7;

/// The direct solver refines to 1e-12.
const DIRECT: f64 = 1e-9;

/// Element size of the part that the tests run, over the smallest radius: twenty thousand unknowns.
const COARSE: f64 = 1.5;

/// What one cell came to.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// Largest relative error of the velocities, and iterations.
    Right { error: f64, iterations: usize },
    /// The message.
    Refused(String),
    /// An answer that claims to be one and is not.
    Wrong { error: f64 },
}

/// One cell of the map.
#[derive(Clone, Debug)]
pub struct Cell {
    pub hardship: &'static str,
    pub formulation: &'static str,
    pub solver: &'static str,
    pub outcome: Outcome,
    pub seconds: f64,
    /// Whether the outcome is the expected one.
    pub as_expected: bool,
}

/// Runs the map, prints it and writes `stability.md` and `stability.csv`; fails if a cell is not as expected.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let clock = Clock::now();
    let (cells, algebra) = map(quick)?;
    report::write(&cells, &algebra, clock.elapsed().as_secs_f64(), out)?;
    let off = cells.iter().filter(|cell| !cell.as_expected).count()
        + algebra.iter().filter(|row| !row.as_expected).count();
    if off > 0 {
        bail!(
            "{off} of {} cells are not as expected",
            cells.len() + algebra.len()
        );
    }
    Ok(())
}

fn map(quick: bool) -> Result<(Vec<Cell>, Vec<algebra::Row>)> {
    let mut cells = Vec::new();
    for hardship in hardships::all() {
        if !quick || hardship.quick {
            eprintln!("{}", hardship.name);
            let mut hardship = hardship;
            if quick {
                hardship.coarsen(COARSE);
            }
            cells.extend(row(&hardship)?);
        }
    }
    Ok((cells, algebra::rows()?))
}

/// All cells of one hardship.
fn row(hardship: &Hardship) -> Result<Vec<Cell>> {
    let truth = match (&hardship.expected, &hardship.truth) {
        (Expected::Refused(_), _) => None,
        (Expected::Right, Truth::Direct) => Some((truth(&hardship.setup)?, 1.0)),
        (Expected::Right, Truth::Similar(setup, factor)) => Some((truth(setup)?, *factor)),
    };
    let mut cells = Vec::new();
    for solver in SOLVERS {
        for formulation in FORMULATIONS {
            let clock = Clock::now();
            let outcome = match solve(&hardship.setup, formulation, solver) {
                Err(error) => Outcome::Refused(error.to_string()),
                Ok(instant) => judge(&instant, truth.as_ref(), solver),
            };
            let expected = match (solver, formulation, hardship.expected) {
                ("minres", "direct-row", Expected::Right) => Expected::Refused("symmetric"),
                (_, _, expected) => expected,
            };
            cells.push(Cell {
                hardship: hardship.name,
                formulation,
                solver,
                as_expected: is_as_expected(&outcome, expected),
                outcome,
                seconds: clock.elapsed().as_secs_f64(),
            });
        }
    }
    Ok(cells)
}

fn is_as_expected(outcome: &Outcome, expected: Expected) -> bool {
    match (outcome, expected) {
        (Outcome::Right { .. }, Expected::Right) => true,
        (Outcome::Refused(message), Expected::Refused(part)) => message.contains(part),
        _ => false,
    }
}

fn truth(setup: &Setup) -> Result<Instant> {
    solve(setup, "p-tilde", "direct").context("the reference of a hardship could not be solved")
}

fn solve(setup: &Setup, formulation: &str, solver: &str) -> Result<Instant, SwimError> {
    let scene = Scene::parse(&setup.toml(formulation, solver))?;
    let mut model = choose(&scene)?.model;
    solve_start(&scene, model.as_mut())
}

/// Right or wrong against velocities times a factor; without a truth nothing should have answered.
fn judge(instant: &Instant, truth: Option<&(Instant, f64)>, solver: &str) -> Outcome {
    let Some((truth, factor)) = truth else {
        return Outcome::Wrong { error: f64::NAN };
    };
    let mut error = 0.0_f64;
    let mut size = 0.0_f64;
    for (found, exact) in instant.bodies.iter().zip(&truth.bodies) {
        let difference = found.velocity / *factor - exact.velocity;
        error = error.max(difference.amax());
        size = size.max(exact.velocity.amax());
        let turn: Vector3<f64> = found.angular_velocity - exact.angular_velocity;
        error = error.max(turn.amax());
        size = size.max(exact.angular_velocity.amax());
    }
    error /= size;
    let tolerance = if solver == "direct" { DIRECT } else { KRYLOV };
    // A NaN is wrong.
    if error <= tolerance {
        Outcome::Right {
            error,
            iterations: instant.solver.iterations,
        }
    } else {
        Outcome::Wrong { error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_map_holds_no_wrong_answer_and_no_surprise() {
        let (cells, algebra) = map(true).unwrap();
        for cell in &cells {
            assert!(cell.as_expected, "{cell:?}");
        }
        for row in &algebra {
            assert!(row.as_expected, "{row:?}");
        }
    }
}
