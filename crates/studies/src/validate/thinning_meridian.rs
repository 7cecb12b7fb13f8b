//! M: fluids whose viscosity depends on the shear rate, by elements in the meridian plane.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::Result;
use axisymmetric::rheology::Law;
use axisymmetric::{AxialBody, AxialSpheroid, SteadyDrive, SteadyParameters, Surroundings};
use axisymmetric::{law_change, steady_state};
use swimmer::models::{AxisymmetricModel, Configuration, Hydrodynamics};
use swimmer::{Scene, run_without_files};

use super::row::{Basis, Cost, Estimated, Row};
use crate::reference::{
    CARREAU_LEGS, CARREAU_SPHERES, CARREAU_SQUIRMER, CARREAU_STROKE, CARREAU_THREE_SPHERES,
    POWER_LAW_SPHERES, broken_scallop, carreau_squirmer_slope,
};
use crate::scenes::SceneText;

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
    if !quick {
        rows.extend(legs()?);
        rows.extend(scallops()?);
    }
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
        let surroundings = match radius.is_finite() {
            true => Surroundings::Ball { radius },
            false => Surroundings::Unbounded,
        };
        let [speed, slope] = three_spheres(centres, surroundings)?;
        let name = format!("three spheres at {centres:?}, ball of {radius}");
        let cost = cost(clock, 0, 0);
        let tolerance = 3.0 * TOLERANCE;
        rows.push(row(
            format!("{name}: speed"),
            [velocity, speed],
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

/// Velocity of the middle one of three spheres whose left link becomes shorter at the rate 1, and
/// its change in units of `(n - 1) / 2 λ^2`.
fn three_spheres(centres: [f64; 3], surroundings: Surroundings) -> Result<[f64; 2]> {
    let law = carreau(0.5, 1e-3, 0.0);
    let unit = -0.25e-6;
    let bodies = centres.map(|centre| AxialBody::free(AxialSpheroid::sphere(centre, 1.0), 0.0, 0));
    let drive = SteadyDrive {
        velocities: &[1.0, 0.0, 0.0],
        ..SteadyDrive::default()
    };
    let found = law_change(&bodies, surroundings, &drive, &law, TOLERANCE)?;
    let change = found
        .by_square
        .map_or(f64::NAN, |change| change.velocities[1]);
    Ok([found.velocities[1], change / unit])
}

/// Speed of a link in the strokes: from 10 to 6 in a unit of time.
const LINK_SPEED: f64 = 4.0;

/// First-order changes of the legs of the three-sphere stroke, by the changes at four Gauss points.
///
/// The change of a configuration has an error of [`TOLERANCE`], that of a leg this times the cube
/// of the speed of the link over that speed.
fn legs() -> Result<Vec<Row>> {
    let root = f64::sqrt(6.0 / 5.0);
    let weight = |sign: f64| (18.0 + sign * f64::sqrt(30.0)) / 36.0;
    let point = |sign: f64| f64::sqrt(3.0 / 7.0 + sign * 2.0 / 7.0 * root);
    let points = [
        (-point(1.0), weight(-1.0)),
        (-point(-1.0), weight(1.0)),
        (point(-1.0), weight(1.0)),
        (point(1.0), weight(-1.0)),
    ];
    let bound = TOLERANCE * LINK_SPEED.powi(3);
    let (mut rows, mut changes, mut costs) = (Vec::new(), Vec::new(), 0.0);
    for (right, exact) in CARREAU_LEGS {
        let clock = Instant::now();
        let mut change = 0.0;
        for (x, weight) in points {
            let left = -(8.0 + 2.0 * x);
            let [_, slope] = three_spheres([left, 0.0, right], Surroundings::Unbounded)?;
            change += LINK_SPEED.powi(3) * 0.5 * weight * slope;
        }
        let name = format!("left link closes, right link {right}: slope of Carreau");
        let cost = cost(clock, 0, 0);
        costs += cost.seconds;
        rows.push(row(name, [exact, change], bound / exact.abs(), cost));
        changes.push(change);
    }
    let cost = Cost {
        seconds: costs,
        ..Cost::default()
    };
    let net = 2.0 * (changes[0] - changes[1]);
    let values = [CARREAU_STROKE[1], net];
    let name = "axisymmetric, three-sphere stroke: slope of Carreau over that of a leg";
    let (scale, tolerance) = (changes[0].abs(), 4.0 * bound / changes[0].abs());
    let tolerance = (tolerance, Basis::Promised);
    rows.push(Row::scaled("M", name, values, scale, tolerance, cost));
    Ok(rows)
}

/// A reciprocal stroke of unequal times: to first order along the Newtonian stroke, and by flows
/// that follow the law.
fn scallops() -> Result<[Row; 2]> {
    let run = |time: f64, rheology: &str| {
        let clock = Instant::now();
        let scene = SceneText::new(format!(
            "fluid = {{ law = \"carreau\", zero_shear_viscosity = 1, relaxation_time = {time}, \
             index = 0.5, rheology = \"{rheology}\" }}\nmodel.tolerance = 1e-3"
        ))
        .swimmer([1.0; 3], [10.0; 2])
        .phase("left", 6.0)
        .key("duration", 1.0)
        .phase("left", 10.0)
        .key("duration", 2.0)
        .parse()?;
        let report = run_without_files(scene, &mut ())?;
        anyhow::Ok((report, cost(clock, 0, 0)))
    };
    let time = 1e-2;
    let (report, cost) = run(time, "newtonian")?;
    let effect = report
        .neglected
        .first()
        .and_then(|neglected| neglected.effect.as_ref().ok());
    let change = effect.and_then(|effect| {
        let (_, vectors) = effect.parts().next()?;
        Some(vectors.first()?.x)
    });
    // `5/8 (λ g)^2` of the law is left out, with shear rates up to 1.5 times the speed of a sphere
    let next = |time: f64| 0.625 * (1.5 * LINK_SPEED * time).powi(2);
    let name = "one arm that closes twice as fast as it opens: first order in Carreau";
    let values = [broken_scallop(time), change.unwrap_or(f64::NAN)];
    let first = row(name.to_owned(), values, next(time) + 1e-3, cost);
    let time = 0.1;
    let (report, cost) = run(time, "full")?;
    let (net, bar) = (
        report.outcome.net_vector().x,
        report.outcome.error_estimate.total(),
    );
    let name = "one arm that closes twice as fast as it opens, Carreau: net";
    // The series of the law alternates: the change is between its first order and that less the
    // next one.
    let half = 0.5 * next(time);
    let exact = (1.0 - half) * broken_scallop(time);
    let second = row(name.to_owned(), [exact, net], half + bar / exact, cost);
    let second = second.with(Estimated::bound(bar)).with_exact_bar(half);
    Ok([first, second])
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
