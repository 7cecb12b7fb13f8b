//! What happens to the tolerance that a scene asks for.

use nalgebra::{UnitQuaternion, Vector3};
use rigid::{StateVelocity, Twist};
use swimmer::models::{
    BodySolution, Capabilities, DiscretisationError, ErrorEstimates, Hydrodynamics,
    InstantaneousSolution, ModelError, Query, Response, Uncertainty,
};
use swimmer::{Method, Scene, SwimError};

use crate::strokes::{FREE, RPY, planar};
use crate::support::{Tensor, TestModel, scene, three_spheres};

#[test]
fn a_tolerance_below_the_noise_of_a_model_is_refused_and_the_best_result_has_an_honest_bar() {
    // Velocities with noise of 1e-3: each step of a phase span is uncertain by up to 1e-3 of its
    // 1.4, the net displacement of 0.165 by 2e-2 to 3e-2 of itself.
    let text = three_spheres("model.tolerance = 1e-4", FREE);
    let refused = simulate_with_noise(&text);
    assert!(matches!(refused, Err(SwimError::NotIntegrated { .. })));
    let best = three_spheres("model = { tolerance = 1e-4, accept = \"best\" }", FREE);
    let outcome = simulate_with_noise(&best).unwrap();
    let exact: f64 = RPY.iter().sum();
    let (error, bar) = (
        (outcome.net() - exact).abs(),
        outcome.limited_error.unwrap(),
    );
    assert!(!outcome.tolerance_met && error <= bar, "{error:e} {bar:e}");
    assert!(bar < 0.3 * exact, "{bar:e}");
}

/// Simulates a stroke by a model whose velocities have relative noise of 1e-3.
fn simulate_with_noise(text: &str) -> Result<swimmer::Outcome, SwimError> {
    let scene = scene(text);
    let mut model = NoisyModel(TestModel::new(&scene, Tensor::Rpy));
    swimmer::simulate(&scene, &mut model, Method::Collocation, &mut ())
}

/// The test model with noise that depends on the configuration, like that of a new mesh.
struct NoisyModel(TestModel);

impl Hydrodynamics for NoisyModel {
    fn name(&self) -> &'static str {
        "noisy"
    }

    fn scene(&self) -> &Scene {
        self.0.scene()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let lengths: f64 = query.configuration.shape.iter().sum();
        // A rapidly oscillating function is noise for any quadrature that does not resolve it.
        let noise = 1e-3 * (1e7 * lengths).sin();
        let mut solutions = self.0.solve(query)?;
        for solution in &mut solutions {
            for frame in &mut solution.motion.frames {
                frame.linear *= 1.0 + noise;
            }
        }
        Ok(solutions)
    }
}

#[test]
fn the_net_displacement_meets_the_tolerance_also_where_it_is_small() {
    // The net displacement of the planar swimmer is 1/370 of the change of length of an arm.
    let outcome = |text: &str| {
        let scene = scene(text);
        let mut model = TestModel::new(&scene, Tensor::Rpy);
        swimmer::simulate(&scene, &mut model, Method::Collocation, &mut ()).unwrap()
    };
    let still = (UnitQuaternion::identity(), Vector3::zeros());
    let at = |tolerance: f64| {
        let text = planar(&still.0, &still.1, "clamped");
        outcome(&text.replace("tolerance = 1e-9", &format!("tolerance = {tolerance}")))
    };
    let (loose, tight) = (at(0.03), at(1e-7));
    let error = (loose.displacement[0] - tight.displacement[0]).norm();
    assert!(error <= loose.error_estimate.integration.unwrap());
    assert!(loose.tolerance_met && error <= 0.03 * tight.net());
    let swimmer = outcome(&three_spheres("model.tolerance = 1e-3", FREE));
    let exact: f64 = RPY.iter().sum();
    assert!(swimmer.tolerance_met && (swimmer.net() - exact).abs() < 1e-3 * exact);
    // Per phase span, orders of one, two and three points, of which the last is accepted, and the
    // end.
    assert_eq!((swimmer.spans.len(), swimmer.solves), (4, 24));
    assert_eq!(swimmer.samples.len(), 1 + 4 * (3 + 1));
}

/// The test model with a factor on its velocities, on a mesh that changes with every solve.
struct Changed<F> {
    model: TestModel,
    factor: F,
    /// Error bar of the mesh, relative to the velocity of the frame.
    bar: f64,
    solves: usize,
}

impl<F: Fn(&[f64]) -> f64 + Send> Hydrodynamics for Changed<F> {
    fn name(&self) -> &'static str {
        "changed"
    }

    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            error_estimates: ErrorEstimates::Always,
            ..Capabilities::default()
        }
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let factor = (self.factor)(query.configuration.shape);
        let mut solutions = self.model.solve(query)?;
        for solution in &mut solutions {
            let mut largest = 0.0_f64;
            for frame in &mut solution.motion.frames {
                frame.linear *= factor;
                largest = largest.max(frame.linear.norm());
            }
            solution.correct(DiscretisationError {
                response: Response {
                    motion: StateVelocity {
                        frames: vec![Twist::default()],
                        spins: vec![Vector3::zeros(); 3],
                        joints: vec![],
                    },
                    bodies: vec![BodySolution::default(); 3],
                    joint_forces: Vec::new(),
                    slip_power: 0.0,
                },
                uncertainty: Uncertainty {
                    relative: 0.0,
                    velocity: self.bar * largest,
                    power: 0.0,
                },
            });
            solution.dofs.total = 1000 + self.solves % 2;
            self.solves += 1;
        }
        Ok(solutions)
    }
}

fn simulate_changed(
    text: &str,
    bar: f64,
    factor: impl Fn(&[f64]) -> f64 + Send,
) -> swimmer::Outcome {
    let scene = scene(text);
    let mut model = Changed {
        model: TestModel::new(&scene, Tensor::Rpy),
        factor,
        bar,
        solves: 0,
    };
    swimmer::simulate(&scene, &mut model, Method::Collocation, &mut ()).unwrap()
}

#[test]
fn differences_between_meshes_are_an_uncertainty_of_the_mesh_and_not_of_the_integration() {
    let text = three_spheres("model.tolerance = 1e-4", FREE);
    let noise = |lengths: &[f64]| 1.0 + 1e-3 * (1e7 * lengths.iter().sum::<f64>()).sin();
    let outcome = simulate_changed(&text, 5e-3, noise);
    let exact: f64 = RPY.iter().sum();
    let error = (outcome.net() - exact).abs();
    let bar = outcome.error_estimate.mesh.unwrap();
    assert!(error <= bar && bar < 0.3 * exact, "{error:e} {bar:e}");
    assert!(outcome.tolerance_met);
}

#[test]
fn a_swimmer_among_too_many_bodies_for_a_prediction_meets_the_tolerance_of_its_spans() {
    let far: String = (0..29)
        .map(|k| {
            format!(
                "[[bodies]]\nname = \"far-{k}\"\nradius = 1\nposition = [{}, 1000, 0]\n",
                50 * k
            )
        })
        .collect();
    let text = three_spheres("model.tolerance = 1e-3", FREE) + &far;
    let scene = scene(&text);
    let mut model = TestModel::new(&scene, Tensor::Rpy);
    let outcome = swimmer::simulate(&scene, &mut model, Method::Collocation, &mut ()).unwrap();
    for span in &outcome.spans {
        // Relative to the change of an arm's length, which is the largest displacement.
        let bar = span.error_estimate.integration.unwrap();
        assert!(bar <= 1e-3 / 160.0 * 4.0, "{bar:e}");
    }
    let exact: f64 = RPY.iter().sum();
    let net = outcome.displacement[1].norm();
    assert!((net - exact).abs() < 1e-3 * exact, "{net} {exact}");
}
