//! Strokes by finite elements: the displacement depends on the path through shape space only.

use nalgebra::Vector3;
use swimmer::choose;
use swimmer::models::Hydrodynamics;
use swimmer::{Method, Observer, Outcome, PhaseSpan, Scene, SpanSolution, SwimError, simulate};

use crate::scenes::{BALL, BODIES, COARSE, parse};

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

/// The bent swimmer through phases of `(arm, length, duration)`; arms are 4.15 and 4.36 long at the
/// start.
fn swimmer(more: &str, phases: &[(&str, f64, f64)]) -> Scene {
    let phases: String = phases
        .iter()
        .map(|(arm, length, duration)| {
            format!(
                "[[gait.phases]]\nlink = \"{arm}-arm\"\nlength = {length:?}\nduration = {duration:?}\n"
            )
        })
        .collect();
    // A vanishing net displacement meets no relative tolerance; the tolerance only sets the
    // accuracy of the integration.
    parse(&format!(
        "{BALL}{COARSE}model.tolerance = 1e-2\n{more}{BODIES}{phases}"
    ))
}

fn follow(scene: &Scene) -> Outcome {
    let mut model = choose(scene).unwrap().model;
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
    let scene = swimmer("", &[("left", 3.5, 1.0)]);
    scene.articulation().initial_shape().try_into().unwrap()
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
    // Corrections would take half of the time; the next test has them.
    let phases = [stroke, reverse].concat();
    let outcome = follow(&swimmer("fem.estimates = \"off\"\n", &phases));
    let half: Vec<Vector3<f64>> = (0..3)
        .map(|body| {
            outcome.spans[..4]
                .iter()
                .map(|span| span.displacement[body])
                .sum()
        })
        .collect();
    let net = largest(&outcome.displacement);
    let allowed = remaining_error(&outcome);
    assert!(net <= allowed, "{net:e} {allowed:e}");
    // The displacement of the first half is much larger.
    assert!(
        largest(&half) > 20.0 * remaining_error(&outcome),
        "{:e} {:e}",
        largest(&half),
        remaining_error(&outcome)
    );
}

#[test]
fn a_reciprocal_stroke_has_no_net_displacement() {
    // The scallop: one arm, closed slowly and opened fast (Purcell 1977).
    let [left_arm, _] = arms();
    let outcome = follow(&swimmer(
        "",
        &[("left", 3.5, 10.0), ("left", left_arm, 0.1)],
    ));
    // Corrections cancel to a part of their error bar: they depend on the position in the ball,
    // which differs by the error of the integration.
    let net = largest(&outcome.displacement);
    let allowed = remaining_error(&outcome) + 0.2 * outcome.error_estimate.mesh.unwrap();
    assert!(net <= allowed, "{net:e} {allowed:e}");
    assert!(largest(&outcome.spans[0].displacement) > 0.1);
}

#[test]
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
    // Corrections would double the time.
    let slow = follow(&swimmer("fem.estimates = \"off\"\n", &phases([1.0; 4])));
    let fast = follow(&swimmer(
        "fem.estimates = \"off\"\nfluid.viscosity = 8.9e-4\n",
        &phases([0.3, 7.0, 1e-3, 40.0]),
    ));
    // Displacements agree up to the algebraic errors of the solves.
    let algebraic = slow.error_estimate.algebraic.unwrap() + fast.error_estimate.algebraic.unwrap();
    for (a, b) in slow.displacement.iter().zip(&fast.displacement) {
        assert!(
            (a - b).norm() <= algebraic,
            "{:e} {algebraic:e}",
            (a - b).norm()
        );
    }
    // The work scales with the viscosity and, phase span by phase span, with the rate.
    assert!(slow.work > 0.0 && fast.work > 0.0);
    assert_eq!(slow.solves, fast.solves);
}
