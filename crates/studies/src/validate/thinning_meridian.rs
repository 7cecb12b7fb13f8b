//! M: fluids whose viscosity depends on the shear rate, by elements in the meridian plane.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::Result;
use axisymmetric::rheology::Law;
use axisymmetric::{AxialBody, AxialSpheroid, SteadyDrive, SteadyParameters, Surroundings};
use axisymmetric::{law_change, steady_state};
use swimmer::Scene;
use swimmer::models::{AxisymmetricModel, Configuration, Hydrodynamics};

use super::row::{Basis, Cost, Estimated, Row};
use crate::reference::{
    CARREAU_SPHERES, CARREAU_SQUIRMER, CARREAU_THREE_SPHERES, POWER_LAW_SPHERES,
    carreau_squirmer_slope,
};

/// Tolerance of flows in the quick part, and of all first-order changes.
const TOLERANCE: f64 = 1e-6;

/// Tolerance of power laws in large balls.
const LARGE_BALL: f64 = 2e-5;

/// All rows; large balls and steep laws are not in the quick part.
pub fn rows(quick: bool) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (index, time, plateau, exact, digits) in
        CARREAU_SPHERES
            .into_iter()
            .take(if quick { 1 } else { CARREAU_SPHERES.len() })
    {
        let name = format!("Carreau, n = {index}, time {time}, mu_inf {plateau}: drag / 6 pi");
        let unit = 6.0 * PI;
        let law = carreau(index, time, plateau);
        rows.push(drag(name, &law, 10.0, exact, unit, TOLERANCE)?.with_exact_bar(digits));
    }
    rows.extend(squirmer()?);
    for (index, radius, exact, digits) in
        POWER_LAW_SPHERES
            .into_iter()
            .take(if quick { 1 } else { POWER_LAW_SPHERES.len() })
    {
        let name = format!("power law, n = {index}, ball of {radius}: drag factor");
        let law = Law::PowerLaw {
            consistency: 1.0,
            index,
            regularisation: 1e-9,
        };
        let tolerance = if radius > 10.0 { LARGE_BALL } else { TOLERANCE };
        let unit = 6.0 * PI * 2.0_f64.powf(1.0 - index);
        rows.push(drag(name, &law, radius, exact, unit, tolerance)?.with_exact_bar(digits));
    }
    rows.extend(first_order()?);
    rows.extend(scene()?);
    Ok(rows)
}

fn carreau(index: f64, relaxation_time: f64, infinite_shear_viscosity: f64) -> Law {
    Law::Carreau {
        zero_shear_viscosity: 1.0,
        infinite_shear_viscosity,
        relaxation_time,
        index,
    }
}

fn row(name: String, values: [f64; 2], tolerance: f64, cost: Cost) -> Row {
    let name = format!("axisymmetric, {name}");
    Row::relative("M", name, values, (tolerance, Basis::Promised), cost)
}

fn cost(clock: Instant, dofs: usize, iterations: usize) -> Cost {
    Cost {
        dofs,
        iterations,
        seconds: clock.elapsed().as_secs_f64(),
    }
}

/// The drag of a sphere that moves at speed 1, over a unit.
fn drag(
    name: String,
    law: &Law,
    radius: f64,
    exact: f64,
    unit: f64,
    tolerance: f64,
) -> Result<Row> {
    let clock = Instant::now();
    let drive = SteadyDrive {
        velocities: &[1.0],
        ..SteadyDrive::default()
    };
    let parameters = SteadyParameters::new(0.0)
        .with_law(law)
        .with_tolerance(tolerance)
        .with_growth(0.3);
    let body = AxialBody::prescribed(AxialSpheroid::sphere(0.0, 1.0));
    let found = steady_state(&[body], Surroundings::Ball { radius }, &drive, &parameters)?;
    let cost = cost(clock, found.dofs, found.iterations);
    let computed = found.forces[0] / unit;
    let row = row(name, [exact, computed], 2.0 * tolerance, cost);
    Ok(row.with(Estimated::bound(found.relative_error * exact)))
}

/// Speed and power of a squirmer in a ball.
fn squirmer() -> Result<[Row; 2]> {
    let clock = Instant::now();
    let slip = |_: usize, [z, r]: [f64; 2]| [-r * r, z * r];
    let drive = SteadyDrive {
        slip: Some(&slip),
        ..SteadyDrive::default()
    };
    let law = carreau(0.5, 1.0, 0.0);
    let parameters = SteadyParameters::new(0.0)
        .with_law(&law)
        .with_tolerance(1e-7);
    let body = AxialBody::free(AxialSpheroid::sphere(0.0, 1.0), 0.0, 0);
    let ball = Surroundings::Ball { radius: 10.0 };
    let found = steady_state(&[body], ball, &drive, &parameters)?;
    let cost = cost(clock, found.dofs, found.iterations);
    let [speed, power] = CARREAU_SQUIRMER;
    let rows = [
        ("speed", speed, 1.5 * found.velocities[0], 1.5e-10),
        ("power", power, found.power / (16.0 / 3.0 * PI), 7e-8),
    ];
    // relative to the largest velocity of the fluid, 1
    Ok(rows.map(|(name, exact, computed, digits)| {
        let name = format!("Carreau squirmer, {name}");
        row(name, [exact, computed], 3e-7, cost)
            .with(Estimated::bound(1.5 * found.relative_error))
            .with_exact_bar(digits)
    }))
}

/// First-order changes in unbounded fluid and in a ball.
fn first_order() -> Result<Vec<Row>> {
    let law = carreau(0.5, 1e-3, 0.0);
    let unit = -0.25e-6;
    let mut rows = Vec::new();
    for beta in [0.0, 1.0] {
        let clock = Instant::now();
        let slip = move |_: usize, [z, r]: [f64; 2]| {
            let speed = 1.5 * r * (1.0 + beta * z);
            [-speed * r, speed * z]
        };
        let drive = SteadyDrive {
            slip: Some(&slip),
            ..SteadyDrive::default()
        };
        let body = AxialBody::free(AxialSpheroid::sphere(0.0, 1.0), 0.0, 0);
        let found = law_change(&[body], Surroundings::Unbounded, &drive, &law, TOLERANCE)?;
        let slope = found
            .by_square
            .map_or(f64::NAN, |change| change.velocities[0] / unit);
        let name = format!("squirmer, beta = {beta}, slope of Carreau");
        let values = [carreau_squirmer_slope(beta), slope];
        rows.push(row(name, values, 10.0 * TOLERANCE, cost(clock, 0, 0)));
    }
    for (centres, radius, velocity, change) in CARREAU_THREE_SPHERES {
        let clock = Instant::now();
        let bodies =
            centres.map(|centre| AxialBody::free(AxialSpheroid::sphere(centre, 1.0), 0.0, 0));
        let drive = SteadyDrive {
            velocities: &[1.0, 0.0, 0.0],
            ..SteadyDrive::default()
        };
        let surroundings = match radius.is_finite() {
            true => Surroundings::Ball { radius },
            false => Surroundings::Unbounded,
        };
        let found = law_change(&bodies, surroundings, &drive, &law, TOLERANCE)?;
        let slope = found
            .by_square
            .map_or(f64::NAN, |change| change.velocities[1] / unit);
        let name = format!("three spheres at {centres:?}, ball of {radius}");
        let cost = cost(clock, 0, 0);
        let tolerance = 3.0 * TOLERANCE;
        rows.push(row(
            format!("{name}: speed"),
            [velocity, found.velocities[1]],
            tolerance,
            cost,
        ));
        // a small difference of changes around the three bodies
        let tolerance = 1e-4;
        rows.push(row(
            format!("{name}: slope of Carreau"),
            [change, slope],
            tolerance,
            cost,
        ));
    }
    Ok(rows)
}

/// The squirmer as a scene, by the model.
fn scene() -> Result<[Row; 2]> {
    let clock = Instant::now();
    let scene = Scene::parse(
        "fluid = { law = \"carreau\", zero_shear_viscosity = 1, relaxation_time = 1, index = 0.5 }\n\
         domain = { kind = \"ball\", radius = 10 }\n\
         model = { kind = \"axisymmetric\", tolerance = 1e-5 }\n\
         bodies = [{ name = \"s\", radius = 1, position = [0, 0, 0], \
         slip = { b1 = 1, axis = [1, 0, 0] } }]",
    )?;
    let mut model = AxisymmetricModel::new(&scene)?;
    let state = scene.initial_state();
    let solution = model.solve_one(Configuration::new(&state, &[]), &[])?;
    let cost = cost(clock, solution.dofs.total, solution.solver.iterations);
    let [speed, power] = CARREAU_SQUIRMER;
    let computed = [
        1.5 * solution.bodies[0].velocity.x,
        solution.power() / (16.0 / 3.0 * PI),
    ];
    let bars = [
        1.5 * solution.error_estimate.total(),
        solution.power_error.total() / (16.0 / 3.0 * PI),
    ];
    let row = |k: usize, name: &str, exact: f64| {
        let name = format!("Carreau squirmer as a scene, {name}");
        let tolerance = (1e-5, Basis::Promised);
        Row::relative("M", name, [exact, computed[k]], tolerance, cost)
            .with(Estimated::bound(bars[k]))
            .with_exact_bar(1e-7)
    };
    Ok([row(0, "speed", speed), row(1, "power", power)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "slow: 40 s"]
    fn all_rows_pass() {
        let rows = rows(true).expect("all are computed");
        println!("{}", super::super::summary::table(&rows).markdown());
        assert!(rows.iter().all(Row::passes));
    }
}
