//! Strokes by finite elements: the displacement depends on the path through shape space only.

use nalgebra::Vector3;
use swimmer::models::Hydrodynamics;
use swimmer::{Method, Observer, Outcome, PhaseSpan, Scene, SpanSolution, SwimError, simulate};

use testkit::{boxed, within};

use crate::scenes::{COARSE_SETTINGS, bodies};

/// Number of meshes generated during a simulation after the first.
#[derive(Default)]
struct Remeshes(usize);

impl Observer for Remeshes {
    fn solved(
        &mut self,
        _: &PhaseSpan,
        solved: &SpanSolution,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        self.0 += usize::from(solved.number > 0 && solved.solution.remeshed.is_some());
        Ok(())
    }
}

/// The bent swimmer through phases of `(arm, length, duration)`.
fn swimmer(settings: &[&str], phases: &[(&str, f64, f64)]) -> Scene {
    let text = phases
        .iter()
        .fold(bodies(), |text, (arm, length, duration)| {
            let keys =
                format!("link = \"{arm}-arm\", length = {length:?}, duration = {duration:?}");
            text.phase(&keys)
        });
    // A vanishing net displacement meets no relative tolerance; the tolerance only sets the
    // accuracy of the integration.
    text.set(&COARSE_SETTINGS)
        .tolerance(1e-2)
        .set(settings)
        .scene()
}

/// Corrections would double the time.
const WITHOUT_CORRECTIONS: &str = "fem.estimates=off";

fn follow(scene: &Scene) -> Outcome {
    let mut model = boxed(scene);
    let mut remeshes = Remeshes::default();
    let outcome = simulate(scene, model.as_mut(), Method::Collocation, &mut remeshes).unwrap();
    // On one moving mesh the discretisation errors are a function of position and shape, as the
    // flow is.
    assert_eq!(remeshes.0, 0);
    outcome
}

/// Errors of the integration and of the solver in a displacement.
fn remaining_error(outcome: &Outcome) -> f64 {
    outcome.error_estimate.integration.unwrap() + outcome.error_estimate.algebraic.unwrap()
}

fn arms() -> [f64; 2] {
    bodies()
        .scene()
        .articulation()
        .initial_shape()
        .try_into()
        .unwrap()
}

fn largest(displacement: &[Vector3<f64>]) -> f64 {
    displacement.iter().map(Vector3::norm).fold(0.0, f64::max)
}

#[test]
#[ignore = "slow: 6 s"]
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
    let phases = [stroke, reverse].concat();
    let outcome = follow(&swimmer(&[WITHOUT_CORRECTIONS], &phases));
    let spans = &outcome.spans[..4];
    let half = [0, 1, 2].map(|body| spans.iter().map(|span| span.displacement[body]).sum());
    let allowed = remaining_error(&outcome);
    within(
        largest(&outcome.displacement),
        allowed,
        "integration and solver",
    );
    within(
        20.0 * allowed,
        largest(&half),
        "the displacement of the first half is much larger",
    );
}

#[test]
fn a_reciprocal_stroke_has_no_net_displacement() {
    // The scallop: one arm, closed slowly and opened fast (Purcell 1977).
    let [left_arm, _] = arms();
    let phases = [("left", 3.5, 10.0), ("left", left_arm, 0.1)];
    let outcome = follow(&swimmer(&[], &phases));
    // They depend on the position in the ball, which differs by the error of the integration.
    let why = "corrections cancel to a part of their error bar";
    let allowed = remaining_error(&outcome) + 0.2 * outcome.error_estimate.mesh.unwrap();
    within(largest(&outcome.displacement), allowed, why);
    assert!(largest(&outcome.spans[0].displacement) > 0.1);
}

#[test]
#[ignore = "slow: 4 s"]
fn displacements_do_not_depend_on_rate_or_viscosity() {
    let [left_arm, right_arm] = arms();
    let phases = |d: [f64; 4]| {
        [
            ("left", 3.5, d[0]),
            ("right", 3.5, d[1]),
            ("left", left_arm, d[2]),
            ("right", right_arm, d[3]),
        ]
    };
    let slow = follow(&swimmer(&[WITHOUT_CORRECTIONS], &phases([1.0; 4])));
    let settings = [WITHOUT_CORRECTIONS, "fluid.viscosity=8.9e-4"];
    let fast = follow(&swimmer(&settings, &phases([0.3, 7.0, 1e-3, 40.0])));
    let algebraic = slow.error_estimate.algebraic.unwrap() + fast.error_estimate.algebraic.unwrap();
    for (a, b) in slow.displacement.iter().zip(&fast.displacement) {
        within(
            (a - b).norm(),
            algebraic,
            "the algebraic errors of the solves",
        );
    }
    // The work scales with the viscosity and, phase span by phase span, with the rate.
    assert!(slow.work > 0.0 && fast.work > 0.0);
    assert_eq!(slow.solves, fast.solves);
}
