//! Case E: the three-sphere swimmer, in single configurations and over whole strokes.

use anyhow::Result;
use swimmer::choose;
use swimmer::models::{AccumulatedError, Hydrodynamics, InstantaneousSolution};
use swimmer::{
    Method, Observer, Outcome, PhaseSpan, Scene, SpanResult, SpanSolution, SwimError, simulate,
};

use super::effort::Effort;
use super::estimated::Estimated;
use super::expected;
use super::flow::{Sphere, scene_by, solve};
use super::row::{Basis, Cost, Row};
use crate::reference::{INSTANTANEOUS, Instantaneous, STROKES, Stroke};
use crate::scene_files;

/// Radius of the ball for single configurations.
const CONTAINER: f64 = 40.0;

/// Radius over distance to the wall, for the outer sphere of the longest arm, which is 10.
const NEAREST: f64 = 1.0 / (CONTAINER - 10.0);

/// Tolerances required by the project: speeds on fine meshes; with default settings, the steps of a
/// stroke (and speeds), and the net displacement.
pub const SPEED: f64 = 1e-4;
const STEP: f64 = 1e-3;
const NET: f64 = 6e-4;

/// Element sizes on the spheres: the default, and one that gives about 300 thousand dofs.
const DEFAULT_SIZE: f64 = 0.4;
const FINE_SIZE: f64 = 0.2;

/// Single configurations: velocity of the middle sphere, and the largest error of the three forces.
///
/// Errors of forces are relative to the largest force.
pub fn configurations(effort: Effort) -> Result<Vec<Row>> {
    let fine = match effort {
        Effort::Quick => &INSTANTANEOUS[..1],
        Effort::Full => &INSTANTANEOUS[..],
    };
    let coarse = INSTANTANEOUS.iter().map(|case| (case, DEFAULT_SIZE, STEP));
    let mut rows = Vec::new();
    for (case, size, speed) in coarse.chain(fine.iter().map(|case| (case, FINE_SIZE, SPEED))) {
        let model = format!("model.kind = \"fem\"\nfem.surface_size = {size:?}");
        let tolerances = [
            (speed, Basis::Required),
            (expected::sphere(size, NEAREST)?.drag, Basis::Interpolation),
        ];
        rows.extend(configuration(
            case,
            &format!("h {size}"),
            &model,
            tolerances,
        )?);
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
    let (solution, cost) = solve(&at(case, CONTAINER, model)?)?;
    let name = format!(
        "arms {} {}, {} {}, {by}",
        case.left_arm,
        case.right_arm,
        if case.left_rate == 0.0 {
            "right"
        } else {
            "left"
        },
        if case.left_rate + case.right_rate < 0.0 {
            "closes"
        } else {
            "opens"
        },
    );
    Ok(compare(&name, case, &solution, tolerances, cost))
}

/// Rows of a solution, with the tolerances of the velocity and of the forces.
pub fn compare(
    name: &str,
    case: &Instantaneous,
    instant: &InstantaneousSolution,
    [velocity, force]: [(f64, Basis); 2],
    cost: Cost,
) -> [Row; 2] {
    let largest = case.forces.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    let miss = |body: &usize| (instant.bodies[*body].force.x - case.forces[*body]).abs();
    let worst = (0..case.forces.len()).max_by(|a, b| miss(a).total_cmp(&miss(b)));
    let worst = worst.unwrap_or(0);
    let speeds = [case.centre_velocity, instant.bodies[1].velocity.x];
    let forces = [case.forces[worst], instant.bodies[worst].force.x];
    [
        Row::relative("E", format!("{name}: U centre"), speeds, velocity, cost)
            .with(Some(Estimated::velocity(instant, 1))),
        Row::scaled("E", format!("{name}: force"), forces, largest, force, cost)
            .with(Estimated::force(instant, worst)),
    ]
}

/// Scene of a configuration in a ball of radius `container`; its first phase changes one arm by one
/// radius in one unit of time.
pub fn at(case: &Instantaneous, container: f64, model: &str) -> Result<Scene> {
    let spheres = [-case.left_arm, 0.0, case.right_arm].map(|position| Sphere {
        position,
        radius: 1.0,
        ..Sphere::default()
    });
    let (joint, length) = match case.left_rate {
        0.0 => ("right", case.right_arm + case.right_rate),
        rate => ("left", case.left_arm + rate),
    };
    let more = format!(
        "[[links]]\nname = \"left\"\nbody = \"s0\"\nto = \"s1\"\n[[links]]\nname = \"right\"\nbody = \"s2\"\nto = \"s1\"\n\
         [[gait.phases]]\nlink = \"{joint}\"\nlength = {length:?}\n"
    );
    scene_by(model, container, &spheres, &more)
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
        self.cost.add(&Cost::of(&solved.solution));
        Ok(())
    }

    fn span_done(
        &mut self,
        _: &PhaseSpan,
        result: &SpanResult,
        _: &Outcome,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        self.accumulated.push(result.accumulated_error.clone());
        Ok(())
    }
}

/// Whole strokes: each step, and the net displacement of the middle sphere.
pub fn strokes(effort: Effort) -> Result<Vec<Row>> {
    let cases = match effort {
        Effort::Quick => &STROKES[..1],
        Effort::Full => &STROKES[..],
    };
    let mut rows = Vec::new();
    for case in cases {
        let tolerances = [(STEP, Basis::Required), (NET, Basis::Required)];
        rows.extend(stroke(case, "", &[], tolerances)?);
    }
    Ok(rows)
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
    let scene = scene_files::read("three-sphere.toml", &overrides)?;
    let mut model = choose(&scene)?.model;
    let mut spans = Spans::default();
    let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut spans)?;
    let cost = spans.cost;
    let name = |what: &str| format!("{by}stroke 10-6, b {}: {what}", case.container);
    let mut rows: Vec<Row> = outcome
        .spans
        .iter()
        .zip(case.steps)
        .enumerate()
        .map(|(number, (span, exact))| {
            let pair = [exact, span.displacement[1].x];
            let what = format!("step {}", number + 1);
            let accumulated = spans.accumulated[number].as_ref();
            let estimated = Estimated::displacement(accumulated, &span.error_estimate);
            Row::relative("E", name(&what), pair, step, cost).with(Some(estimated))
        })
        .collect();
    let pair = [case.net, outcome.displacement[1].x];
    let estimated =
        Estimated::displacement(outcome.accumulated_error.as_ref(), &outcome.error_estimate);
    rows.push(Row::relative("E", name("net"), pair, net, cost).with(Some(estimated)));
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validate::bars::assert_corrected;

    #[test]
    fn speed_and_force_of_a_swimmer_are_corrected_and_within_their_bars() {
        let tolerances = [(STEP, Basis::Required); 2];
        // The whole fluid, and a quarter of it.
        for (name, fem) in [
            ("h 0.5", "fem = { surface_size = 0.5, symmetry = \"off\" }"),
            ("h 0.4", "fem.surface_size = 0.4"),
        ] {
            let model = format!("model.kind = \"fem\"\n{fem}");
            for row in
                configuration(&INSTANTANEOUS[0], name, &model, tolerances).expect("it is solved")
            {
                assert_corrected(&row);
            }
        }
    }
}
