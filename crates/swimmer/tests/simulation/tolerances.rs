//! What happens to the tolerance that a scene asks for.

use swimmer::models::{Capabilities, DiscretisationError, ErrorEstimates, Uncertainty};
use swimmer::{Method, Outcome, SwimError};
use testkit::exact::STROKE_RPY;
use testkit::{Recording, SceneText, planar, run_by, three_spheres, within};

use crate::support::{Tensor, TestModel};

fn outcome(text: &SceneText) -> Outcome {
    let mut model = TestModel::new(&text.scene(), Tensor::Rpy);
    run_by(&mut model, Method::Collocation)
}

/// A rapidly oscillating function of the lengths is noise for any quadrature that does not resolve
/// it, like that of a new mesh; of the size 1e-3 relative to one.
fn noise(lengths: &[f64]) -> f64 {
    1.0 + 1e-3 * (1e7 * lengths.iter().sum::<f64>()).sin()
}

#[test]
fn a_tolerance_below_the_noise_of_a_model_is_refused_and_the_best_result_has_an_honest_bar() {
    // Velocities with noise of 1e-3: each step of a phase span is uncertain by up to 1e-3 of its
    // 1.4, the net displacement of 0.165 by 2e-2 to 3e-2 of itself.
    let with_noise = |text: &SceneText| {
        let scene = text.scene();
        let model = TestModel::new(&scene, Tensor::Rpy);
        let mut model = Recording::changing(model, |query, solutions| {
            for frame in solutions.iter_mut().flat_map(|s| &mut s.motion.frames) {
                frame.linear *= noise(query.configuration.shape);
            }
        });
        swimmer::simulate(&scene, &mut model, Method::Collocation, &mut ())
    };
    let text = three_spheres().tolerance(1e-4);
    let refused = with_noise(&text);
    assert!(matches!(refused, Err(SwimError::NotIntegrated { .. })));
    let outcome = with_noise(&text.with("model.accept", "best")).unwrap();
    let bar = outcome.limited_error.unwrap();
    assert!(!outcome.tolerance_met);
    within(outcome.net() - STROKE_RPY, bar, "the error bar");
    within(
        bar,
        0.3 * STROKE_RPY,
        "ten times the noise of the net displacement",
    );
}

#[test]
fn the_net_displacement_meets_the_tolerance_also_where_it_is_small() {
    // The net displacement of the planar swimmer is 1/370 of the change of length of an arm.
    let at = |tolerance: f64| outcome(&planar(|x| x).tolerance(tolerance));
    let (loose, tight) = (at(0.03), at(1e-7));
    let error = (loose.displacement[0] - tight.displacement[0]).norm();
    within(
        error,
        loose.error_estimate.integration.unwrap(),
        "the error bar",
    );
    within(error, 0.03 * tight.net(), "the tolerance");
    assert!(loose.tolerance_met);
    let swimmer = outcome(&three_spheres().tolerance(1e-3));
    assert!(swimmer.tolerance_met);
    within(
        swimmer.net() - STROKE_RPY,
        1e-3 * STROKE_RPY,
        "the tolerance",
    );
    // Per phase span, orders of one, two and three points, of which the last is accepted, and the
    // end.
    assert_eq!((swimmer.spans.len(), swimmer.solves), (4, 24));
    assert_eq!(swimmer.samples.len(), 1 + 4 * (3 + 1));
}

#[test]
fn differences_between_meshes_are_an_uncertainty_of_the_mesh_and_not_of_the_integration() {
    let model = TestModel::new(&three_spheres().tolerance(1e-4).scene(), Tensor::Rpy);
    let mut solves = 0;
    // A mesh that changes with every solve, with an error bar of 5e-3 of the velocity of the frame.
    let mut model = Recording::changing(model, |query, solutions| {
        for solution in solutions {
            let mut largest = 0.0_f64;
            for frame in &mut solution.motion.frames {
                frame.linear *= noise(query.configuration.shape);
                largest = largest.max(frame.linear.norm());
            }
            let uncertainty = Uncertainty {
                velocity: 5e-3 * largest,
                ..Uncertainty::default()
            };
            let response = &solution.response * 0.0;
            solution.correct(DiscretisationError {
                response,
                uncertainty,
            });
            solution.dofs.total = 1000 + solves % 2;
            solves += 1;
        }
    });
    let error_estimates = ErrorEstimates::Always;
    model.capabilities = Capabilities {
        error_estimates,
        ..Capabilities::default()
    };
    let outcome = run_by(&mut model, Method::Collocation);
    let bar = outcome.error_estimate.mesh.unwrap();
    within(outcome.net() - STROKE_RPY, bar, "the error bar");
    within(
        bar,
        0.3 * STROKE_RPY,
        "ten times the noise of the net displacement",
    );
    assert!(outcome.tolerance_met);
}

#[test]
fn a_swimmer_among_too_many_bodies_for_a_prediction_meets_the_tolerance_of_its_spans() {
    let text = (0..29).fold(three_spheres().tolerance(1e-3), |text, k| {
        text.sphere(&format!("far-{k}"), 1.0, [50 * k, 1000, 0])
    });
    let outcome = outcome(&text);
    for span in &outcome.spans {
        let bar = span.error_estimate.integration.unwrap();
        within(
            bar,
            1e-3 / 160.0 * 4.0,
            "relative to the change of an arm's length",
        );
    }
    let net = outcome.displacement[1].norm();
    within(net - STROKE_RPY, 1e-3 * STROKE_RPY, "the tolerance");
}
