//! One instantaneous solution by finite elements: formulations x solvers x stress cases.

use anyhow::{Context, Result};
use nalgebra::Vector3;
use swimmer::SwimError;
use swimmer::models::InstantaneousSolution;

use super::map::{Cell, Expected, Map, Outcome, Store};
use super::stress_cases::{self, Setup, StressCase};
use crate::scenes::solve;

const FORMULATIONS: [(&str, &str); 3] =
    [("p-tilde", "P~"), ("lagrange", "L"), ("direct-row", "DR")];
const SOLVERS: [&str; 4] = ["block", "minres", "schwarz", "direct"];

/// Tolerance of velocities for Krylov solvers, which stop at a true residual of 1e-10.
///
/// A relative residual `r` causes errors up to `r` times the ratio of the largest to the smallest
/// resistance, which is below 1e3 for these scenes, including the one with the smallest gap.
const KRYLOV: f64 = 1e-7;

/// Tolerance of velocities for the direct solver, whose iterative refinement stops at 1e-12.
const DIRECT_TOLERANCE: f64 = 1e-9;

/// Element size of the part that the tests run, over the smallest radius: twenty thousand dofs.
const COARSE_SIZE: f64 = 1.5;

/// The map.
pub fn map(quick: bool, store: &mut Store) -> Result<Map> {
    let columns = SOLVERS
        .iter()
        .flat_map(|solver| FORMULATIONS.map(|(_, short)| format!("{solver} {short}")));
    let mut map = Map {
        key: "flow",
        title: "Finite elements: formulations and solvers",
        note: "P~: elimination; L: Lagrange multipliers; DR: direct rows. A number means that the answer is right, and is the number of iterations. Velocities are compared with an \
               independent solve: to 1e-7 for Krylov solvers, which stop at a true residual of 1e-10, and to 1e-9 for the direct one.",
        columns: columns.collect(),
        ..Map::default()
    };
    for mut case in stress_cases::all() {
        if quick {
            case.coarsen(COARSE_SIZE);
        }
        if !quick || case.quick {
            map.add(store, case.name, || cells(&case))?;
        }
    }
    Ok(map)
}

/// All cells of one stress case.
fn cells(case: &StressCase) -> Result<Vec<Cell>> {
    let (setup, factor) = case
        .truth
        .as_ref()
        .map_or((&case.setup, 1.0), |it| (&it.0, it.1));
    let truth = match case.expected {
        Expected::Right => Some(solve_by(setup, "p-tilde", "direct").context("no reference")?),
        _ => None,
    };
    let mut cells = Vec::new();
    for solver in SOLVERS {
        for (formulation, _) in FORMULATIONS {
            let expected = match (solver, formulation, case.expected) {
                ("minres", "direct-row", Expected::Right) => Expected::Refused("symmetric"),
                (_, _, expected) => expected,
            };
            let tolerance = if solver == "direct" {
                DIRECT_TOLERANCE
            } else {
                KRYLOV
            };
            let compare = |found: InstantaneousSolution| match &truth {
                // Without a reference, any solution is wrong.
                None => Outcome::wrong(f64::NAN),
                Some(truth) => compare(&found, truth, factor, tolerance),
            };
            let compute = || solve_by(&case.setup, formulation, solver);
            cells.push(Cell::new(expected, compute, compare));
        }
    }
    Ok(cells)
}

fn solve_by(
    setup: &Setup,
    formulation: &str,
    solver: &str,
) -> Result<InstantaneousSolution, SwimError> {
    solve(&setup.scene(formulation, solver)?)
}

/// Compares velocities with those of the reference times a factor.
fn compare(
    found: &InstantaneousSolution,
    truth: &InstantaneousSolution,
    factor: f64,
    tolerance: f64,
) -> Outcome {
    let mut error = 0.0_f64;
    let mut size = 0.0_f64;
    for (found, exact) in found.bodies.iter().zip(&truth.bodies) {
        let difference = found.velocity / factor - exact.velocity;
        error = error.max(difference.amax());
        size = size.max(exact.velocity.amax());
        let turn: Vector3<f64> = found.angular_velocity - exact.angular_velocity;
        error = error.max(turn.amax());
        size = size.max(exact.angular_velocity.amax());
    }
    // If all reference velocities are zero, the absolute error counts.
    if size > 0.0 {
        error /= size;
    }
    let mark = found.solver.iterations.to_string();
    Outcome::within(error, tolerance, mark)
}
