//! Corrections of discretisation errors along a phase span.

use swimmer::models::{
    Capabilities, Configuration, DiscretisationError, ErrorEstimates, Hydrodynamics,
    InstantaneousSolution, ModelError, Query, SphereModel, SpheresModel, Uncertainty,
};
use swimmer::{Method, Scene, simulate};

use crate::strokes::FREE;
use crate::support::{scene, three_spheres};

/// A model of spheres whose solutions are a few percent too large, by a smooth function of the
/// lengths, unless estimates are requested.
struct OnRequest {
    model: SpheresModel,
    /// Number of requests.
    requests: usize,
    /// Whether estimates can be requested.
    estimates: ErrorEstimates,
}

impl OnRequest {
    fn new(scene: &Scene, estimates: ErrorEstimates) -> Self {
        Self {
            model: SpheresModel::new(scene, SphereModel::Rpy).unwrap(),
            requests: 0,
            estimates,
        }
    }
}

impl Hydrodynamics for OnRequest {
    fn name(&self) -> &'static str {
        self.model.name()
    }

    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            error_estimates: self.estimates,
            ..Capabilities::default()
        }
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let mut solutions = self.model.solve(query)?;
        let shape = query.configuration.shape;
        let relative = 1e-2 * (shape[0] / 10.0 + (shape[1] / 8.0).powi(2));
        for solution in &mut solutions {
            let uncertainty = Uncertainty {
                relative: 0.05,
                velocity: 0.0,
                power: 0.0,
            };
            let error = DiscretisationError {
                response: &solution.response * relative,
                uncertainty,
            };
            if query.estimates {
                self.requests += 1;
                solution.error_estimate.mesh = Some(error.velocity_error_bar());
                solution.mesh_error = Some(error);
            } else {
                let opposite = DiscretisationError::combination([(-1.0, &error)]).unwrap();
                solution.correct(opposite);
                solution.mesh_error = None;
                solution.error_estimate.mesh = None;
            }
        }
        Ok(solutions)
    }
}

/// Net displacement and work.
fn stroke(scene: &Scene, model: &mut OnRequest) -> [f64; 2] {
    let outcome = simulate(scene, model, Method::Collocation, &mut ()).unwrap();
    assert_eq!(outcome.error_estimate.mesh.is_some(), model.requests > 0);
    [outcome.displacement[1].x, outcome.work]
}

#[test]
fn corrections_at_two_points_of_a_span_serve_all_points() {
    let scene = scene(&three_spheres("model.tolerance = 1e-6", FREE));
    let mut exact = SpheresModel::new(&scene, SphereModel::Rpy).unwrap();
    let exact = simulate(&scene, &mut exact, Method::Collocation, &mut ()).unwrap();
    let exact = [exact.displacement[1].x, exact.work];
    let mut uncorrected = OnRequest::new(&scene, ErrorEstimates::Never);
    let uncorrected = stroke(&scene, &mut uncorrected);
    let mut model = OnRequest::new(&scene, ErrorEstimates::OnRequest);
    let corrected = stroke(&scene, &mut model);
    assert_eq!(model.requests, 2 * 4, "two on each of four phase spans");
    for k in 0..2 {
        let [before, after] =
            [uncorrected[k], corrected[k]].map(|value| (value / exact[k] - 1.0).abs());
        // Two points integrate the velocities to 1e-2 of what one point leaves, and corrections,
        // relative to them, likewise.
        assert!(
            before > 5e-3 && after <= 1e-2 * before,
            "{k}: {before:e} {after:e}"
        );
    }
}

#[test]
fn corrections_between_points_follow_the_polynomial_through_them() {
    // Of a linear combination of two errors, each part has its factor.
    let scene = scene(&three_spheres("model.tolerance = 1e-2", FREE));
    let mut model = OnRequest::new(&scene, ErrorEstimates::OnRequest);
    let state = scene.initial_state();
    let shape = scene.articulation().initial_shape().to_vec();
    let configuration = Configuration {
        state: &state,
        shape: &shape,
    };
    let rates = [vec![1.0, 0.0], vec![0.0, 1.0]];
    let query = Query::new(configuration, &rates).with_estimates(true);
    let errors: Vec<DiscretisationError> = (model.solve(&query).unwrap().into_iter())
        .map(|solution| solution.mesh_error.unwrap())
        .collect();
    let sum = DiscretisationError::combination([(3.0, &errors[0]), (-2.0, &errors[1])]).unwrap();
    let body = |error: &DiscretisationError| error.bodies[2];
    let vectors = |error: &DiscretisationError| {
        let body = body(error);
        [
            body.velocity,
            body.force,
            error.joint_forces[1],
            error.motion.frames[0].linear,
        ]
    };
    let parts = vectors(&errors[0]).into_iter().zip(vectors(&errors[1]));
    for (sum, (a, b)) in vectors(&sum).into_iter().zip(parts) {
        assert!((sum - (3.0 * a - 2.0 * b)).norm() <= 1e-15 * (a.norm() + b.norm()));
    }
    assert_eq!(sum.uncertainty.relative, 0.05);
    assert!(DiscretisationError::combination([]).is_none());
}
