//! Strokes: only their path through the shapes counts.

use nalgebra::Vector3;
use swimmer::choose;
use swimmer::models::Hydrodynamics;
use swimmer::{Leg, LegSolution, Method, Observer, Outcome, Scene, SwimError, simulate};

use crate::scenes::{BALL, BODIES, COARSE, parse};

/// Meshes made during a simulation, beside the first.
#[derive(Default)]
struct Remeshes(usize);

impl Observer for Remeshes {
    fn solved(
        &mut self,
        _: &Leg,
        solved: &LegSolution,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        self.0 += usize::from(solved.number > 0 && solved.solution.remeshed.is_some());
        Ok(())
    }
}

/// The bent swimmer through phases of `(arm, length, duration)`; arms are 4.15 and 4.36 long at the start.
fn swimmer(more: &str, phases: &[(&str, f64, f64)]) -> Scene {
    let phases: String = phases
        .iter()
        .map(|(arm, length, duration)| {
            format!("[[gait.phases]]\nlink = \"{arm}-arm\"\nlength = {length:?}\nduration = {duration:?}\n")
        })
        .collect();
    // Net displacements that vanish meet no share of themselves: the tolerance only says how much work to spend.
    parse(&format!(
        "{BALL}{COARSE}model.tolerance = 1e-2\n{more}{BODIES}{phases}"
    ))
}

fn follow(scene: &Scene) -> Outcome {
    let mut model = choose(scene).unwrap().model;
    let mut remeshes = Remeshes::default();
    let outcome = simulate(scene, model.as_mut(), Method::Collocation, &mut remeshes).unwrap();
    // One mesh, moved with the shape: discretisation errors are a function of place and shape, as the flow is.
    assert_eq!(remeshes.0, 0);
    outcome
}

/// Error that integration and solves leave in a displacement.
fn left(outcome: &Outcome) -> f64 {
    outcome.error_estimate.integration.unwrap() + outcome.error_estimate.algebraic.unwrap()
}

fn arms() -> [f64; 2] {
    let scene = swimmer("", &[("left", 3.5, 1.0)]);
    scene.articulation().initial_lengths().try_into().unwrap()
}

fn largest(displacement: &[Vector3<f64>]) -> f64 {
    displacement.iter().map(Vector3::norm).fold(0.0, f64::max)
}

#[test]
fn a_stroke_and_its_reverse_cancel() {
    let [left_arm, right_arm] = arms();
    let stroke = [
        ("left", 3.5, 1.0),
        ("right", 3.5, 1.0),
        ("left", left_arm, 1.0),
        ("right", right_arm, 1.0),
    ];
    let reverse = [
        ("right", 3.5, 1.0),
        ("left", 3.5, 1.0),
        ("right", right_arm, 1.0),
        ("left", left_arm, 1.0),
    ];
    let outcome = follow(&swimmer("", &[stroke, reverse].concat()));
    let half: Vec<Vector3<f64>> = (0..3)
        .map(|body| {
            outcome.legs[..4]
                .iter()
                .map(|leg| leg.displacement[body])
                .sum()
        })
        .collect();
    let net = largest(&outcome.displacement);
    assert!(net <= left(&outcome), "{net:e} {:e}", left(&outcome));
    // It went somewhere meanwhile, far beyond that.
    assert!(
        largest(&half) > 20.0 * left(&outcome),
        "{:e} {:e}",
        largest(&half),
        left(&outcome)
    );
}

#[test]
fn a_reciprocal_stroke_goes_nowhere() {
    // The scallop: one arm, closed slowly and opened fast (Purcell 1977).
    let [left_arm, _] = arms();
    let outcome = follow(&swimmer(
        "",
        &[("left", 3.5, 10.0), ("left", left_arm, 0.1)],
    ));
    let net = largest(&outcome.displacement);
    assert!(net <= left(&outcome), "{net:e} {:e}", left(&outcome));
    assert!(largest(&outcome.legs[0].displacement) > 0.1);
}

#[test]
fn rate_and_viscosity_do_not_matter() {
    let [left_arm, right_arm] = arms();
    let phases = |d: [f64; 4]| {
        [
            ("left", 3.5, d[0]),
            ("right", 3.5, d[1]),
            ("left", left_arm, d[2]),
            ("right", right_arm, d[3]),
        ]
    };
    let slow = follow(&swimmer("", &phases([1.0; 4])));
    let fast = follow(&swimmer(
        "fluid.viscosity = 8.9e-4\n",
        &phases([0.3, 7.0, 1e-3, 40.0]),
    ));
    // Displacements are the same but for the solves, each of which errs by its own tolerance.
    let algebraic = slow.error_estimate.algebraic.unwrap() + fast.error_estimate.algebraic.unwrap();
    for (a, b) in slow.displacement.iter().zip(&fast.displacement) {
        assert!(
            (a - b).norm() <= algebraic,
            "{:e} {algebraic:e}",
            (a - b).norm()
        );
    }
    // Work is force times path: it scales with viscosity and, leg by leg, with the rate.
    assert!(slow.work > 0.0 && fast.work > 0.0);
    assert_eq!(slow.solves, fast.solves);
}
