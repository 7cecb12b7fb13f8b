//! M: fluids whose viscosity depends on the shear rate.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::Result;
use swimmer::Scene;
use swimmer::models::InstantaneousSolution;

use super::row::{Basis, Cost, Estimated, Row};
use crate::reference::{CARREAU_SPHERES, CARREAU_SQUIRMER, POWER_LAW_SPHERES};
use crate::scenes::solve;

/// Required of forces, speeds and powers by elements.
const REQUIRED: f64 = 2e-3;

/// All rows; the quick part has one of each kind.
pub fn rows(quick: bool) -> Result<Vec<Row>> {
    let held = "velocity = [1, 0, 0], angular_velocity = [0, 0, 0]";
    let mut rows = Vec::new();
    let count = if quick { 1 } else { usize::MAX };
    for &(index, time, infinite, exact, _) in CARREAU_SPHERES.iter().take(count) {
        let fluid = carreau(time, index, infinite);
        let (solution, cost) = solved(&fluid, held)?;
        let name =
            format!("sphere, Carreau, index {index}, shear number {time}, {infinite}: force");
        let force = solution.bodies[0].force.x / (6.0 * PI);
        let bar = solution.force_error.total() / (6.0 * PI);
        rows.push(required(name, [exact, force], cost).with(Estimated::bound(bar)));
    }
    let small = POWER_LAW_SPHERES.iter().filter(|sphere| sphere.1 == 10.0);
    for &(index, _, exact, _) in small.take(count) {
        let fluid = format!("law = \"power-law\", consistency = 1, index = {index}");
        let (solution, cost) = solved(&fluid, held)?;
        let unit = 6.0 * PI * 2.0_f64.powf(1.0 - index);
        let name = format!("sphere, power law, index {index}: force");
        let force = solution.bodies[0].force.x / unit;
        let bar = solution.force_error.total() / unit;
        rows.push(required(name, [exact, force], cost).with(Estimated::bound(bar)));
    }
    let [speed, power] = CARREAU_SQUIRMER;
    let slip = "slip = { b1 = 1, b2 = 0, axis = [1, 0, 0] }";
    let (solution, cost) = solved(&carreau(1.0, 0.5, 0.0), slip)?;
    let computed = solution.bodies[0].velocity.x / (2.0 / 3.0);
    let bar = solution.error_estimate.total() / (2.0 / 3.0);
    let name = "squirmer, Carreau, index 0.5, shear number 1: speed".to_owned();
    rows.push(required(name, [speed, computed], cost).with(Estimated::bound(bar)));
    let unit = 16.0 * PI / 3.0;
    let bar = solution.power_error.total() / unit;
    let name = "squirmer, Carreau, index 0.5, shear number 1: power".to_owned();
    let computed = solution.power() / unit;
    rows.push(required(name, [power, computed], cost).with(Estimated::bound(bar)));
    Ok(rows)
}

fn carreau(time: f64, index: f64, infinite: f64) -> String {
    format!(
        "law = \"carreau\", zero_shear_viscosity = 1, infinite_shear_viscosity = {infinite}, \
         relaxation_time = {time}, index = {index}"
    )
}

fn required(name: String, values: [f64; 2], cost: Cost) -> Row {
    Row::relative("M", name, values, (REQUIRED, Basis::Required), cost)
}

/// A unit sphere at the centre of a ball of radius 10, by elements in space.
fn solved(fluid: &str, body: &str) -> Result<(InstantaneousSolution, Cost)> {
    let clock = Instant::now();
    let scene = Scene::parse(&format!(
        "fluid = {{ {fluid} }}\ndomain = {{ kind = \"ball\", radius = 10 }}\n\
         model.kind = \"fem\"\nfem.size_factor = 0.4\n\
         bodies = [{{ name = \"s\", radius = 1, position = [0, 0, 0], {body} }}]"
    ))?;
    let solution = solve(&scene)?;
    let cost = Cost {
        seconds: clock.elapsed().as_secs_f64(),
        ..Cost::default()
    };
    Ok((solution, cost))
}
