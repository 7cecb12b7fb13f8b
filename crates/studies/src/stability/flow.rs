//! One instant by finite elements: formulations x solvers x hardships.

use std::time::Instant as Clock;

use anyhow::{Context, Result};
use nalgebra::Vector3;
use swimmer::choose;
use swimmer::models::InstantaneousSolution;
use swimmer::{Scene, SwimError, solve_start};

use super::hardships::{self, Expected, Hardship, Truth};
use super::map::{Cell, Map, Outcome};
use super::setup::Setup;
use super::store::Store;

const FORMULATIONS: [(&str, &str); 3] =
    [("p-tilde", "P~"), ("lagrange", "L"), ("direct-row", "DR")];
const SOLVERS: [&str; 4] = ["block", "minres", "schwarz", "direct"];

/// Krylov solvers stop at a true residual of 1e-10. Velocities react to a relative residual `r` with errors up to `r` times
/// the ratio of the largest to the smallest resistance in play: below 1e3 for the scenes here, the closest gap included.
const KRYLOV: f64 = 1e-7;

/// The direct solver refines to 1e-12.
const DIRECT: f64 = 1e-9;

/// Element size of the part that the tests run, over the smallest radius: twenty thousand unknowns.
const COARSE: f64 = 1.5;

/// The map.
pub fn map(quick: bool, store: &mut Store) -> Result<Map> {
    let mut rows = Vec::new();
    for mut hardship in hardships::all() {
        if !quick || hardship.quick {
            if quick {
                hardship.coarsen(COARSE);
            }
            rows.push(store.row("flow", hardship.name, || cells(&hardship))?);
        }
    }
    let columns = SOLVERS
        .iter()
        .flat_map(|solver| FORMULATIONS.map(|(_, short)| format!("{solver} {short}")));
    Ok(Map {
        key: "flow",
        title: "Finite elements: formulations and solvers",
        note: "P~: elimination; L: Lagrange multipliers; DR: direct rows. A number is the right answer in so many iterations: velocities against an \
               independent solve, to 1e-7 for Krylov solvers stopped at a true residual of 1e-10, to 1e-9 for the direct one.",
        columns: columns.collect(),
        rows,
    })
}

/// All cells of one hardship.
fn cells(hardship: &Hardship) -> Result<Vec<Cell>> {
    let truth = match (&hardship.expected, &hardship.truth) {
        (Expected::Refused(_), _) => None,
        (Expected::Right, Truth::Direct) => Some((truth(&hardship.setup)?, 1.0)),
        (Expected::Right, Truth::Similar(setup, factor)) => Some((truth(setup)?, *factor)),
    };
    let mut cells = Vec::new();
    for solver in SOLVERS {
        for (formulation, _) in FORMULATIONS {
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
                as_expected: expected.is_met(&outcome),
                outcome,
                seconds: clock.elapsed().as_secs_f64(),
            });
        }
    }
    Ok(cells)
}

fn truth(setup: &Setup) -> Result<InstantaneousSolution> {
    solve(setup, "p-tilde", "direct").context("the reference of a hardship could not be solved")
}

fn solve(
    setup: &Setup,
    formulation: &str,
    solver: &str,
) -> Result<InstantaneousSolution, SwimError> {
    let scene = Scene::parse(&setup.toml(formulation, solver))?;
    let mut model = choose(&scene)?.model;
    solve_start(&scene, model.as_mut())
}

/// Right or wrong against velocities times a factor; without a truth nothing should have answered.
fn judge(
    instant: &InstantaneousSolution,
    truth: Option<&(InstantaneousSolution, f64)>,
    solver: &str,
) -> Outcome {
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
    // Where nothing moves, nothing may move.
    if size > 0.0 {
        error /= size;
    }
    let tolerance = if solver == "direct" { DIRECT } else { KRYLOV };
    // A NaN is wrong.
    if error <= tolerance {
        Outcome::Right {
            error,
            mark: instant.solver.iterations.to_string(),
        }
    } else {
        Outcome::Wrong { error }
    }
}
