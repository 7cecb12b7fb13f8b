//! Corrections of discretisation errors along a phase span.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use swimmer::models::{
    Capabilities, DiscretisationError, ErrorEstimates, Hydrodynamics, Query, SphereModel,
    SpheresModel, Uncertainty,
};
use swimmer::{Method, Scene};
use testkit::{Recording, run_by, three_spheres, within};

/// A model of spheres whose solutions are a few percent too large, by a smooth function of the
/// lengths, unless estimates are requested; and the number of requests.
fn on_request(scene: &Scene, estimates: ErrorEstimates) -> (Recording<'_>, Arc<AtomicUsize>) {
    let requests = Arc::new(AtomicUsize::new(0));
    let counted = requests.clone();
    let model = SpheresModel::new(scene, SphereModel::Rpy).unwrap();
    let mut model = Recording::changing(model, move |query, solutions| {
        let shape = query.configuration.shape;
        let relative = 1e-2 * (shape[0] / 10.0 + (shape[1] / 8.0).powi(2));
        for solution in solutions {
            let uncertainty = Uncertainty {
                relative: 0.05,
                ..Uncertainty::default()
            };
            let response = &solution.response * relative;
            let error = DiscretisationError {
                response,
                uncertainty,
            };
            if query.estimates {
                counted.fetch_add(1, Ordering::Relaxed);
                solution.error_estimate.mesh = Some(error.velocity_error_bar());
                solution.mesh_error = Some(error);
            } else {
                let opposite = DiscretisationError::combination([(-1.0, &error)]).unwrap();
                solution.correct(opposite);
                solution.mesh_error = None;
                solution.error_estimate.mesh = None;
            }
        }
    });
    let error_estimates = estimates;
    model.capabilities = Capabilities {
        error_estimates,
        ..Capabilities::default()
    };
    (model, requests)
}

/// Net displacement and work, and the number of requests.
fn stroke(scene: &Scene, estimates: ErrorEstimates) -> ([f64; 2], usize) {
    let (mut model, requests) = on_request(scene, estimates);
    let outcome = run_by(&mut model, Method::Collocation);
    let requests = requests.load(Ordering::Relaxed);
    assert_eq!(outcome.error_estimate.mesh.is_some(), requests > 0);
    ([outcome.displacement[1].x, outcome.work], requests)
}

#[test]
fn corrections_at_two_points_of_a_span_serve_all_points() {
    let scene = three_spheres().tolerance(1e-6).scene();
    let mut exact = SpheresModel::new(&scene, SphereModel::Rpy).unwrap();
    let exact = run_by(&mut exact, Method::Collocation);
    let exact = [exact.displacement[1].x, exact.work];
    let (uncorrected, _) = stroke(&scene, ErrorEstimates::Never);
    let (corrected, requests) = stroke(&scene, ErrorEstimates::OnRequest);
    assert_eq!(requests, 2 * 4, "two on each of four phase spans");
    for k in 0..2 {
        let [before, after] = [uncorrected[k], corrected[k]].map(|value| value / exact[k] - 1.0);
        assert!(before.abs() > 5e-3, "{k}: {before:e}");
        // Two points integrate the velocities to 1e-2 of what one point leaves.
        within(
            after,
            1e-2 * before.abs(),
            "corrections are relative to velocities",
        );
    }
}

#[test]
fn corrections_between_points_follow_the_polynomial_through_them() {
    // Of a linear combination of two errors, each part has its factor.
    let scene = three_spheres().tolerance(1e-2).scene();
    let (mut model, _) = on_request(&scene, ErrorEstimates::OnRequest);
    let state = scene.initial_state();
    let shape = scene.articulation().initial_shape().to_vec();
    let configuration = testkit::at(&state, &shape);
    let rates = [vec![1.0, 0.0], vec![0.0, 1.0]];
    let query = Query::new(configuration, &rates).with_estimates(true);
    let errors: Vec<DiscretisationError> = (model.solve(&query).unwrap().into_iter())
        .map(|solution| solution.mesh_error.unwrap())
        .collect();
    let sum = DiscretisationError::combination([(3.0, &errors[0]), (-2.0, &errors[1])]).unwrap();
    let vectors = |error: &DiscretisationError| {
        let (body, frame) = (error.bodies[2], error.motion.frames[0]);
        [
            body.velocity,
            body.force,
            error.joint_loads[1].force,
            frame.linear,
        ]
    };
    let parts = vectors(&errors[0]).into_iter().zip(vectors(&errors[1]));
    for (sum, (a, b)) in vectors(&sum).into_iter().zip(parts) {
        let error = (sum - (3.0 * a - 2.0 * b)).norm();
        within(error, 1e-15 * (a.norm() + b.norm()), "rounding");
    }
    assert_eq!(sum.uncertainty.relative, 0.05);
    assert!(DiscretisationError::combination([]).is_none());
}
