//! Fluids with a viscosity law where the law is hard: at rest, steep, below a yield stress.

use anyhow::Result;
use swimmer::models::InstantaneousSolution;
use swimmer::{Scene, SwimError};

use super::map::{Cell, Expected, Map, Outcome, Store};
use crate::scenes::solve;

const MODELS: [&str; 2] = ["axisymmetric", "fem"];

/// Tolerance of the models, and that of the reference in the meridian plane.
const TOLERANCES: [f64; 2] = [1e-2, 1e-4];

/// Rounding of a speed that is zero, relative to one per time unit.
const ROUNDING: f64 = 1e-9;

/// A sphere in a ball of five radii, pulled along x.
struct Case {
    name: &'static str,
    fluid: &'static str,
    force: f64,
    /// Exact speed; `None` for that of the reference.
    exact: Option<f64>,
    expected: Expected,
    quick: bool,
}

const fn pulled(name: &'static str, fluid: &'static str, expected: Expected) -> Case {
    Case {
        name,
        fluid,
        force: 1.0,
        exact: None,
        expected,
        quick: false,
    }
}

const CASES: [Case; 6] = [
    Case {
        force: 0.0,
        exact: Some(0.0),
        quick: true,
        ..pulled(
            "a power law at rest, index 0.5",
            "law = \"power-law\", consistency = 1, index = 0.5",
            Expected::Right,
        )
    },
    pulled(
        "a power law, index 0.3",
        "law = \"power-law\", consistency = 0.05, index = 0.3",
        Expected::Right,
    ),
    pulled(
        "a power law, index 0.1",
        "law = \"power-law\", consistency = 0.05, index = 0.1",
        Expected::NotWrong,
    ),
    Case {
        exact: Some(0.0),
        ..pulled(
            "a load below the yield stress",
            "law = \"herschel-bulkley\", consistency = 1, index = 0.5, yield_stress = 3, \
             regularisation = 1e-3",
            Expected::NotWrong,
        )
    },
    pulled(
        "viscosities from 1 to 1e-6",
        "law = \"carreau\", zero_shear_viscosity = 1, infinite_shear_viscosity = 1e-6, \
         relaxation_time = 100, index = 0.3",
        Expected::NotWrong,
    ),
    pulled(
        "a fluid that thickens, index 1.8",
        "law = \"power-law\", consistency = 1, index = 1.8",
        Expected::Right,
    ),
];

/// The map.
pub fn map(quick: bool, store: &mut Store) -> Result<Map> {
    let mut map = Map {
        key: "laws",
        title: "Fluids with a viscosity law",
        note: "A sphere in a ball of five radii that a force of 1 pulls, at a tolerance of 1e-2: the \
               speed is the exact one, or that of the meridian plane at a tolerance of 1e-4, within \
               twice the bars. A number means that the answer is right, and is the number of \
               iterations.",
        columns: MODELS.map(String::from).to_vec(),
        ..Map::default()
    };
    for case in CASES.iter().filter(|case| !quick || case.quick) {
        map.add(store, case.name, || Ok(cells(case)))?;
    }
    Ok(map)
}

fn solved(case: &Case, model: &str, tolerance: f64) -> Result<InstantaneousSolution, SwimError> {
    let Case { fluid, force, .. } = case;
    solve(&Scene::parse(&format!(
        "fluid = {{ {fluid} }}\ndomain = {{ kind = \"ball\", radius = 5 }}\n\
         model = {{ kind = \"{model}\", tolerance = {tolerance:?}, accept = \"best\" }}\n\
         bodies = [{{ name = \"s\", radius = 1, position = [0, 0, 0], force = [{force:?}, 0, 0] }}]"
    ))?)
}

/// The speed, and its bar.
fn speed(solution: &InstantaneousSolution) -> [f64; 2] {
    let bar = solution.error_estimate.total();
    [solution.bodies[0].velocity.x, bar]
}

/// Both models. Without a reference no number is right.
fn cells(case: &Case) -> Vec<Cell> {
    let [tolerance, of_reference] = TOLERANCES;
    let known = match case.exact {
        Some(speed) => [speed, 0.0],
        None => {
            solved(case, MODELS[0], of_reference).map_or([f64::NAN; 2], |solution| speed(&solution))
        }
    };
    let cell = |model: &str| {
        let compute = || solved(case, model, tolerance);
        Cell::new(case.expected, compute, |found: InstantaneousSolution| {
            let [value, bar] = speed(&found);
            let mark = found.solver.iterations.to_string();
            Outcome::against_bar((value - known[0]).abs(), bar + known[1], ROUNDING, mark)
        })
    };
    MODELS.map(cell).to_vec()
}
