//! Case E: the three-sphere swimmer, in single configurations and over whole strokes.

use std::f64::consts::PI;
use std::path::Path;

use anyhow::{Context, Result};
use mesh::TetMesh;
use swimmer::models::{AccumulatedError, Hydrodynamics, InstantaneousSolution};
use swimmer::{
    Method, Observer, Outcome, PhaseSpan, Scene, SpanResult, SpanSolution, SwimError, choose,
    simulate, solve_start,
};

use super::expected;
use super::row::{Basis, Cost, Estimated, Row};
use crate::reference::{INSTANTANEOUS, Instantaneous, STROKES, Stroke};
use crate::scenes::{self, UNIT_RATE, by_elements, in_ball, solve};

/// Radius of the ball for single configurations.
const CONTAINER: f64 = 40.0;

/// Radius over distance to the wall, for the outer sphere of the longest arm, which is 10.
const NEAREST: f64 = 1.0 / (CONTAINER - 10.0);

/// Tolerances required by the project: speeds on fine meshes, and forces on the mesh file; with
/// default settings, the steps of a stroke (and speeds), and the net displacement.
const SPEED: f64 = 1e-4;
const FORCE: f64 = 1e-3;
const STEP: f64 = 1e-3;
const NET: f64 = 6e-4;

/// Element sizes on the spheres: the default, and one that gives about 300 thousand dofs.
const DEFAULT_SIZE: f64 = 0.4;
const FINE_SIZE: f64 = 0.2;

/// Single configurations: velocity of the middle sphere, and the largest error of the three forces.
///
/// Errors of forces are relative to the largest force.
pub fn configurations(quick: bool) -> Result<Vec<Row>> {
    let fine = &INSTANTANEOUS[..if quick { 1 } else { INSTANTANEOUS.len() }];
    let coarse = INSTANTANEOUS.iter().map(|case| (case, DEFAULT_SIZE, STEP));
    let mut rows = Vec::new();
    for (case, size, speed) in coarse.chain(fine.iter().map(|case| (case, FINE_SIZE, SPEED))) {
        let tolerances = [
            (speed, Basis::Required),
            (expected::sphere(size, NEAREST)?.drag, Basis::Interpolation),
        ];
        let by = format!("h {size}");
        rows.extend(configuration(case, &by, &by_elements(size), tolerances)?);
    }
    Ok(rows)
}

/// Rows of one configuration; `model` are the lines of the scene that choose the model.
pub fn configuration(
    case: &Instantaneous,
    by: &str,
    model: &str,
    tolerances: [(f64, Basis); 2],
) -> Result<[Row; 2]> {
    let solution = solve(&at(case, CONTAINER, model)?)?;
    let [left, right] = case.rates;
    let moving = if left == 0.0 { "right" } else { "left" };
    let way = if left + right < 0.0 {
        "closes"
    } else {
        "opens"
    };
    let arms = format!("arms {} {}", case.arms[0], case.arms[1]);
    let name = format!("{arms}, {moving} {way}, {by}");
    Ok(compare(&name, case, &solution, tolerances))
}

/// Rows of a solution, with the tolerances of the velocity and of the forces.
fn compare(
    name: &str,
    case: &Instantaneous,
    solution: &InstantaneousSolution,
    [velocity, force]: [(f64, Basis); 2],
) -> [Row; 2] {
    let cost = Cost::new(solution);
    let largest = case.forces.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    let miss = |body: &usize| (solution.bodies[*body].force.x - case.forces[*body]).abs();
    let worst = (0..case.forces.len()).max_by(|a, b| miss(a).total_cmp(&miss(b)));
    let worst = worst.unwrap_or(0);
    let speeds = [case.centre_velocity, solution.bodies[1].velocity.x];
    let forces = [case.forces[worst], solution.bodies[worst].force.x];
    [
        Row::relative("E", format!("{name}: U centre"), speeds, velocity, cost)
            .with(Estimated::velocity(solution, 1)),
        Row::scaled("E", format!("{name}: force"), forces, largest, force, cost)
            .with(Estimated::force(solution, worst)),
    ]
}

/// Scene of a configuration in a ball of radius `container`; its first phase changes one arm by one
/// radius in one unit of time.
fn at(case: &Instantaneous, container: f64, model: &str) -> Result<Scene> {
    let (joint, length) = match case.rates {
        [0.0, rate] => ("right", case.arms[1] + rate),
        [rate, _] => ("left", case.arms[0] + rate),
    };
    let text = in_ball(container, model).swimmer([1.0; 3], case.arms);
    text.phase(joint, length).parse()
}

/// Rows on a mesh of three unit spheres in a ball of radius 40 by Gmsh, first order, 2917 vertices,
/// at the start of the stroke with curved and with straight elements.
pub fn on_mesh_file(_: bool) -> Result<Vec<Row>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../mesh/tests/fixtures");
    let path = folder.join("three-spheres-v41-binary.msh");
    let rows = ["curved", "straight"].map(|geometry| at_start(&path, geometry));
    Ok(rows.into_iter().collect::<Result<Vec<_>>>()?.concat())
}

fn at_start(path: &Path, geometry: &str) -> Result<[Row; 2]> {
    let overrides = [
        format!("domain.file={}", path.display()),
        format!("fem.geometry={geometry}"),
        UNIT_RATE.to_owned(),
    ];
    let scene = scenes::read("three-sphere-mesh.toml", &overrides)?;
    let mut model = choose(&scene)?.model;
    let solution = solve_start(&scene, model.as_mut())?;
    let flow = solution.flow.as_ref().context("the solution has no flow")?;
    let mesh = &flow.field()?.mesh;
    let [of_velocity, of_forces] = effect_of_wall(mesh)?;
    // The radius of the unit sphere minus that of the ball with the volume inside the flat facets.
    let radius_deficit = 1.0 - radius_inside(mesh, "sphere1")?;
    let tolerances = match geometry {
        "curved" => [(SPEED, Basis::Required), (FORCE, Basis::Required)],
        _ => [(2.0 * radius_deficit, Basis::Facets); 2],
    };
    let name = format!("mesh file, {geometry}");
    let [velocity, force] = compare(&name, &INSTANTANEOUS[0], &solution, tolerances);
    Ok([
        velocity.with_exact_bar(of_velocity),
        force.with_exact_bar(of_forces),
    ])
}

/// Radius of the ball with the volume inside the facets of a boundary part.
fn radius_inside(mesh: &TetMesh, tag: &str) -> Result<f64> {
    let volume = fem::surface_measures(mesh, mesh.tag(tag)?)?.volume;
    Ok((volume.abs() / (4.0 / 3.0 * PI)).cbrt())
}

/// Relative changes of velocity and forces if the ball has the volume inside the wall's facets.
///
/// The file has a polyhedron for the ball of the exact values. Its shape is given, so solutions
/// are not corrected for it.
fn effect_of_wall(mesh: &TetMesh) -> Result<[f64; 2]> {
    let radius = radius_inside(mesh, "outer")?;
    let case = &INSTANTANEOUS[0];
    let inside = solve(&at(case, radius, "model.kind = \"multipole\"")?)?;
    let change = |body: usize| (inside.bodies[body].force.x - case.forces[body]).abs();
    let largest = case.forces.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    Ok([
        (inside.bodies[1].velocity.x / case.centre_velocity - 1.0).abs(),
        (0..case.forces.len()).map(change).fold(0.0, f64::max) / largest,
    ])
}

/// Cost of the solves of a stroke, and accumulated errors of its phase spans.
#[derive(Default)]
struct Spans {
    cost: Cost,
    accumulated: Vec<Option<AccumulatedError>>,
}

impl Observer for Spans {
    fn solved(
        &mut self,
        _: &PhaseSpan,
        solved: &SpanSolution,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        self.cost.add(&Cost::new(&solved.solution));
        Ok(())
    }

    fn span_done(
        &mut self,
        _: &PhaseSpan,
        result: &SpanResult,
        _: &Outcome,
        _: &mut dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        self.accumulated.push(result.accumulated_error.clone());
        Ok(())
    }
}

/// Whole strokes: each step, and the net displacement of the middle sphere.
pub fn strokes(quick: bool) -> Result<Vec<Row>> {
    let cases = &STROKES[..if quick { 1 } else { STROKES.len() }];
    let tolerances = [(STEP, Basis::Required), (NET, Basis::Required)];
    let rows = cases.iter().map(|case| stroke(case, "", &[], tolerances));
    Ok(rows.collect::<Result<Vec<_>>>()?.concat())
}

/// Rows of a stroke of the default scene with `overrides`.
///
/// `by` is the name of the method. The tolerances are those of the steps and of the net
/// displacement.
pub fn stroke(
    case: &Stroke,
    by: &str,
    overrides: &[String],
    [step, net]: [(f64, Basis); 2],
) -> Result<Vec<Row>> {
    let mut overrides = overrides.to_vec();
    overrides.push(format!("domain.radius={:?}", case.container));
    let scene = scenes::read("three-sphere.toml", &overrides)?;
    let mut model = choose(&scene)?.model;
    let mut spans = Spans::default();
    let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut spans)?;
    let row = |what: &str, values: [f64; 2], tolerance, estimated: Estimated| {
        let name = format!("{by}stroke 10-6, b {}: {what}", case.container);
        Row::relative("E", name, values, tolerance, spans.cost).with(estimated)
    };
    let mut rows = Vec::new();
    for (number, (span, exact)) in outcome.spans.iter().zip(case.steps).enumerate() {
        let accumulated = spans.accumulated[number].as_ref();
        let estimated = Estimated::displacement(accumulated, &span.error_estimate);
        let what = format!("step {}", number + 1);
        rows.push(row(&what, [exact, span.displacement[1].x], step, estimated));
    }
    let accumulated = outcome.accumulated_error.as_ref();
    let estimated = Estimated::displacement(accumulated, &outcome.error_estimate);
    let values = [case.net, outcome.displacement[1].x];
    rows.push(row("net", values, net, estimated));
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::super::row::assert_corrected;
    use super::*;

    #[test]
    fn speed_and_force_of_a_swimmer_are_corrected_and_within_their_bars() {
        let tolerances = [(STEP, Basis::Required); 2];
        // The whole fluid, and a quarter of it.
        for (name, fem) in [
            ("h 0.5", "fem = { surface_size = 0.5, mirror = \"off\" }"),
            ("h 0.4", "fem.surface_size = 0.4"),
        ] {
            let model = format!("model.kind = \"fem\"\n{fem}");
            let rows = configuration(&INSTANTANEOUS[0], name, &model, tolerances);
            rows.expect("it is solved")
                .iter()
                .for_each(assert_corrected);
        }
    }
}
