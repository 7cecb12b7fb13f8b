//! L: fluids with inertia: steady states, starts from rest, falling spheres.

use std::f64::consts::PI;
use std::time::Instant;

use anyhow::Result;
use swimmer::{Scene, run_without_files, solve_steady};

use super::row::{Basis, Cost, Estimated, Row};
use crate::reference::{FALLING_SPHERES, HELD_SPHERE, RELEASED_SPHERE, STEADY_SQUIRMERS};

/// Required of a steady force or speed by elements.
const STEADY: f64 = 2e-3;

/// The same in the meridian plane.
const STEADY_IN_PLANE: f64 = 2e-7;

/// Half of the last digits of the exact values.
const DIGITS: f64 = 5e-9;

/// Required of the speed after a start from rest.
const RELEASED: f64 = 5e-3;

/// The same in the meridian plane: the tolerance of the steps.
const RELEASED_IN_PLANE: f64 = 3e-3;

/// Required of the net displacement of a stroke by elements in space of the default size.
const STROKE: f64 = 5e-2;

/// A model of a fluid with inertia.
#[derive(Clone, Copy)]
struct Model {
    name: &'static str,
    keys: &'static str,
}

const SPACE: Model = Model {
    name: "elements in space",
    keys: "model.kind = \"fem\"",
};

const PLANE: Model = Model {
    name: "meridian plane",
    keys: "model.kind = \"axisymmetric\"",
};

/// Required of the largest speed of a falling sphere, which is known to a hundredth, the first one
/// by a simulation.
const FALLING: f64 = 1.5e-2;

/// All rows; spheres that fall, half a minute, are not in the quick part.
pub fn rows(quick: bool) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (model, required) in [(SPACE, STEADY), (PLANE, STEADY_IN_PLANE)] {
        rows.extend(steady_states(model, required)?);
    }
    for (model, required) in [(SPACE, RELEASED), (PLANE, RELEASED_IN_PLANE)] {
        rows.extend(released(model, required)?);
    }
    if !quick {
        rows.extend(stroke()?);
        rows.extend(falling()?);
    }
    Ok(rows)
}

/// Forces and speeds in steady flow by one model.
fn steady_states(model: Model, accuracy: f64) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (reynolds, exact) in HELD_SPHERE {
        let held = "velocity = [1, 0, 0], angular_velocity = [0, 0, 0]";
        let (steady, cost) = steady(model, 0.5 * reynolds, held)?;
        let name = format!(
            "sphere held in a stream, Re = {reynolds}: force, {}",
            model.name
        );
        let force = steady.solution.bodies[0].force.x / (6.0 * PI);
        let row = required(name, [exact, force], accuracy, cost);
        let bar = steady.solution.force_error.total() / (6.0 * PI);
        rows.push(row.with(Estimated::bound(bar + DIGITS)));
    }
    for (beta, density, exact) in STEADY_SQUIRMERS {
        let slip = format!(
            "slip = {{ b1 = 1.5, b2 = {}, axis = [1, 0, 0] }}",
            1.5 * beta
        );
        let (steady, cost) = steady(model, density, &slip)?;
        let name = format!(
            "squirmer, beta = {beta}, Re = {density}: speed, {}",
            model.name
        );
        let speed = steady.solution.bodies[0].velocity.x;
        let row = required(name, [exact, speed], accuracy, cost);
        let bar = steady.solution.error_estimate.total() + DIGITS;
        rows.push(row.with(Estimated::bound(bar)));
    }
    Ok(rows)
}

fn required(name: String, values: [f64; 2], tolerance: f64, cost: Cost) -> Row {
    Row::relative("L", name, values, (tolerance, Basis::Required), cost)
}

fn cost(clock: Instant) -> Cost {
    Cost {
        seconds: clock.elapsed().as_secs_f64(),
        ..Cost::default()
    }
}

/// The steady state of a unit sphere at the centre of a ball of radius 10.
fn steady(model: Model, density: f64, body: &str) -> Result<(swimmer::SteadySolution, Cost)> {
    let clock = Instant::now();
    let scene = Scene::parse(&format!(
        "fluid.density = {density}\ndomain = {{ kind = \"ball\", radius = 10 }}\n\
         {}\nfem.size_factor = 0.5\n\
         bodies = [{{ name = \"s\", radius = 1, position = [0, 0, 0], {body} }}]",
        model.keys
    ))?;
    Ok((solve_steady(&scene, &mut ())?, cost(clock)))
}

/// Speeds of a sphere that is released in a ball, before it has moved far.
fn released(model: Model, accuracy: f64) -> Result<Vec<Row>> {
    let clock = Instant::now();
    let mut phases = Vec::new();
    let mut before = 0.0;
    for (time, _) in RELEASED_SPHERE {
        phases.push(format!("{{ duration = {} }}", time - before));
        before = time;
    }
    // The weight less the buoyancy is 6π / 1000.
    let scene = Scene::parse(&format!(
        "fluid = {{ density = 1, inertia = \"unsteady\" }}\n\
         domain = {{ kind = \"ball\", radius = 10 }}\n\
         {}\nmodel.tolerance = 3e-3\nfem.size_factor = 0.7\ngravity = [0, 0, 4.5e-3]\n\
         bodies = [{{ name = \"s\", radius = 1, density = 2, position = [0, 0, 0] }}]\n\
         gait.phases = [{}]",
        model.keys,
        phases.join(", ")
    ))?;
    let outcome = run_without_files(scene, &mut ())?.completed()?.outcome;
    let cost = cost(clock);
    let rows = RELEASED_SPHERE.into_iter().enumerate();
    let row = |(number, (time, exact)): (usize, (f64, f64))| {
        let of_span = (outcome.samples.iter().rev()).filter(|sample| sample.span == number);
        let last = of_span.filter_map(|sample| sample.bodies.as_ref()).next();
        let speed = last.map_or(f64::NAN, |bodies| bodies[0].velocity.z * 1e3);
        let name = format!(
            "sphere released from rest, time {time}: speed, {}",
            model.name
        );
        required(name, [exact, speed], accuracy, cost)
    };
    Ok(rows.map(row).collect())
}

/// Net displacement of the first stroke of three spheres from rest at a Reynolds number of 1, by
/// elements in space against the meridian plane, within the bars of both.
fn stroke() -> Result<Vec<Row>> {
    let run = |model: Model| -> Result<(f64, f64, Cost)> {
        let clock = Instant::now();
        let phase = |link: &str, length: u32| {
            format!("{{ link = \"{link}\", length = {length}, duration = 4 }}")
        };
        let phases = [("l", 6), ("r", 6), ("l", 10), ("r", 10)].map(|(l, x)| phase(l, x));
        let scene = Scene::parse(&format!(
            "fluid = {{ density = 1, inertia = \"full\" }}\n\
             domain = {{ kind = \"ball\", radius = 20 }}\n{}\nmodel.tolerance = 1e-2\n\
             bodies = [{{ name = \"left\", radius = 1, position = [-10, 0, 0] }},\n\
             {{ name = \"centre\", radius = 1, position = [0, 0, 0] }},\n\
             {{ name = \"right\", radius = 1, position = [10, 0, 0] }}]\n\
             links = [{{ name = \"l\", body = \"left\", to = \"centre\" }},\n\
             {{ name = \"r\", body = \"right\", to = \"centre\" }}]\n\
             gait.phases = [{}]",
            model.keys,
            phases.join(", ")
        ))?;
        let outcome = run_without_files(scene, &mut ())?.completed()?.outcome;
        let bar = outcome.error_estimate.total();
        Ok((outcome.displacement[1].x, bar, cost(clock)))
    };
    let (exact, exact_bar, in_plane) = run(PLANE)?;
    let (found, bar, cost) = run(SPACE)?;
    let seconds = in_plane.seconds;
    let name = format!("three-sphere stroke at Re = 1: net displacement ({seconds:.0} s in plane)");
    // In space the tolerance does not limit the bar of the mesh.
    let row = required(name, [exact, found], STROKE, cost);
    let row = row.with_exact_bar(exact_bar / exact.abs());
    Ok(vec![row.with(Estimated::bound(bar))])
}

/// Largest speeds of a sphere that falls in a box, in millimetres, seconds and grams.
fn falling() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (name, density, viscosity, duration, exact) in FALLING_SPHERES {
        let clock = Instant::now();
        let scene = Scene::parse(&format!(
            "fluid = {{ density = {density}, viscosity = {viscosity}, inertia = \"full\" }}\n\
             domain = {{ kind = \"box\", size = [100, 100, 160] }}\n\
             model.tolerance = 1e-2\nfem.size_factor = 0.8\ngravity = [0, 0, -9800]\n\
             bodies = [{{ name = \"s\", radius = 7.5, density = 1.12e-3, position = [0, 0, 47.5] }}]\n\
             gait.phases = [{{ duration = {duration} }}]"
        ))?;
        let outcome = run_without_files(scene, &mut ())?.completed()?.outcome;
        let samples = (outcome.samples.iter()).filter_map(|sample| sample.bodies.as_ref());
        let fastest = samples.fold(0.0_f64, |most, bodies| most.max(-bodies[0].velocity.z));
        let name = format!("sphere falling in a box, {name}: largest speed");
        let row = required(name, [exact, fastest], FALLING, cost(clock));
        // Of the properties of the fluid.
        rows.push(row.with_exact_bar(1e-2));
    }
    Ok(rows)
}
