//! Steady states at high Reynolds numbers, in the meridian plane and in space.

use anyhow::{Context, Result};
use swimmer::{Scene, SteadySolution, SwimError, solve_steady};

use super::map::{Cell, Expected, Map, Outcome, Store};

const MODELS: [&str; 2] = ["axisymmetric", "fem"];

/// `ρ U a / μ`; the flow around a sphere in unbounded fluid is steady up to 105.
const REYNOLDS: [f64; 8] = [1.0, 18.0, 47.0, 50.0, 60.0, 80.0, 100.0, 150.0];

/// Largest Reynolds number at which a steady state must be found.
const MAX_REYNOLDS: f64 = 100.0;

/// Factor on the element sizes in space.
const SIZE_FACTOR: f64 = 0.6;

/// The map.
pub fn map(quick: bool, store: &mut Store) -> Result<Map> {
    let mut map = Map {
        key: "steady",
        title: "Steady states with inertia",
        note: "A sphere in a ball of ten radii that moves with it, pulled by the drag of a fixed one in the meridian plane: the speed is that of the wall around the fixed one, \
               within twice the bars. A number means that the answer is right, and is the number of nonlinear iterations.",
        columns: MODELS.map(String::from).to_vec(),
        ..Map::default()
    };
    for reynolds in REYNOLDS {
        if !quick || reynolds == 47.0 {
            let case = format!("a pulled sphere, Re = {reynolds}");
            map.add(store, case, || cells(reynolds))?;
        }
    }
    Ok(map)
}

fn solve(model: &str, reynolds: f64, body: &str) -> Result<SteadySolution, SwimError> {
    let scene = Scene::parse(&format!(
        "fluid = {{ density = {reynolds:?} }}\ndomain = {{ kind = \"ball\", radius = 10 }}\n\
         model.kind = \"{model}\"\nfem.size_factor = {SIZE_FACTOR}\n\
         bodies = [{{ name = \"s\", radius = 1, position = [0, 0, 0], {body} }}]"
    ))?;
    solve_steady(&scene, &mut ())
}

/// Both models for one Reynolds number.
fn cells(reynolds: f64) -> Result<Vec<Cell>> {
    let held = "velocity = [1, 0, 0], angular_velocity = [0, 0, 0]";
    let fixed = solve(MODELS[0], reynolds, held).context("no reference");
    let expected = match reynolds <= MAX_REYNOLDS {
        true => Expected::Right,
        false => Expected::NotWrong,
    };
    let cell = |model: &str| {
        let compute = || {
            let force = match &fixed {
                Ok(fixed) => fixed.solution.bodies[0].force.x,
                Err(_) => f64::NAN,
            };
            solve(model, reynolds, &format!("force = [{force:?}, 0, 0]"))
        };
        Cell::new(expected, compute, |found: SteadySolution| {
            let speed = found.solution.bodies[0].velocity.x;
            let bar = found.solution.error_estimate.total();
            let of_force = (fixed.as_ref()).map_or(f64::NAN, |fixed| {
                fixed.solution.force_error.total() / fixed.solution.bodies[0].force.x.abs()
            });
            let mark = found.iterations.to_string();
            Outcome::against_bar((speed - 1.0).abs(), bar + of_force, 1e-9, mark)
        })
    };
    Ok(MODELS.map(cell).to_vec())
}
