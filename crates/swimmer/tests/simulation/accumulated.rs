//! Errors of the velocities accumulate to errors of the displacements and of the work.

use approx::{assert_abs_diff_eq, assert_relative_eq};
use nalgebra::Vector3;
use rigid::{StateVelocity, Twist};
use swimmer::models::{
    BodySolution, Capabilities, DiscretisationError, ErrorEstimate, Hydrodynamics,
    InstantaneousSolution, ModelError, Query, Response, Uncertainty,
};
use swimmer::{Method, Outcome, Scene, simulate};

use crate::strokes::FREE;
use crate::support::{Tensor, TestModel, scene, three_spheres};

/// The test model with constant errors, of which only those of the motion are real.
struct Erring {
    exact: TestModel,
    bars: ErrorEstimate,
    power_bars: ErrorEstimate,
    mesh_error: DiscretisationError,
    controls_error: bool,
    /// Whether the errors are subtracted, so that the answer is exact.
    is_corrected: bool,
}

impl Erring {
    fn new(scene: &Scene, error: Twist) -> Self {
        Self {
            exact: TestModel::new(scene, Tensor::Rpy),
            bars: ErrorEstimate::default(),
            power_bars: ErrorEstimate::default(),
            mesh_error: DiscretisationError {
                response: Response {
                    motion: StateVelocity {
                        frames: vec![error],
                        spins: vec![error.angular; 3],
                        joints: vec![],
                    },
                    bodies: vec![BodySolution::default(); 3],
                    joint_forces: vec![Vector3::zeros(); 2],
                    slip_power: 0.0,
                },
                uncertainty: Uncertainty::default(),
            },
            is_corrected: true,
            controls_error: false,
        }
    }
}

impl Hydrodynamics for Erring {
    fn name(&self) -> &'static str {
        "erring"
    }

    fn scene(&self) -> &Scene {
        self.exact.scene()
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            controls_error: self.controls_error,
            ..Capabilities::default()
        }
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let mut solutions = self.exact.solve(query)?;
        for solution in &mut solutions {
            solution.response += &self.mesh_error.response;
            solution.error_estimate = self.bars;
            solution.power_error = self.power_bars;
            if self.is_corrected {
                solution.correct(self.mesh_error.clone());
            }
        }
        Ok(solutions)
    }
}

/// Phases of the durations 1/2, 1/2, 1 and 1.
fn stroke() -> Scene {
    let text = three_spheres("model.tolerance = 1e-6", FREE);
    scene(&text.replace("length = 6\n", "length = 6\nduration = 0.5\n"))
}

const DURATION: f64 = 3.0;

fn follow(model: &mut Erring, method: Method) -> Outcome {
    simulate(&stroke(), model, method, &mut ()).unwrap()
}

#[test]
fn error_bars_of_a_run_are_those_of_the_velocities_times_the_duration() {
    let bars = |unit: f64| ErrorEstimate {
        container: Some(unit),
        model: Some(2.0 * unit),
        algebraic: Some(4.0 * unit),
        ..ErrorEstimate::default()
    };
    let error = Twist {
        linear: Vector3::new(3e-7, 0.0, 4e-7),
        angular: Vector3::zeros(),
    };
    let mut model = Erring::new(&stroke(), error);
    (model.bars, model.power_bars) = (bars(1e-6), bars(1e-5));
    model.mesh_error.uncertainty = Uncertainty {
        relative: 0.2,
        velocity: 1e-7,
        power: 0.0,
    };
    // An error of one body, whose power is far from zero.
    model.mesh_error.bodies[0].force = Vector3::x() * 1e-3;
    for method in [Method::Collocation, Method::Euler { steps: 5 }] {
        let outcome = follow(&mut model, method);
        for (found, unit) in [(&outcome.error_estimate, 1e-6), (&outcome.work_error, 1e-5)] {
            let expected = bars(unit * DURATION);
            for (found, expected) in [
                (found.container, expected.container),
                (found.model, expected.model),
                (found.algebraic, expected.algebraic),
            ] {
                assert_relative_eq!(found.unwrap(), expected.unwrap(), max_relative = 1e-13);
            }
        }
        for (span, duration) in outcome.spans.iter().zip([0.5, 0.5, 1.0, 1.0]) {
            let found = span.error_estimate.model.unwrap();
            assert_relative_eq!(found, 2e-6 * duration, max_relative = 1e-13);
            let found = span.error_estimate.mesh.unwrap();
            assert!(
                (1e-7 * duration..1.5e-7 * duration).contains(&found),
                "{found:e}"
            );
        }
        // Errors of known sign are summed with their signs, uncertainties on one mesh as they are.
        for found in outcome.mesh_error.as_ref().unwrap() {
            let exact = error.linear * DURATION;
            assert_abs_diff_eq!(*found, exact, epsilon = 1e-13 * exact.norm());
        }
        let uncertainty = outcome.accumulated_error.as_ref().unwrap().uncertainty;
        let expected = match method {
            // Within a phase span they are summed, phase spans are independent.
            Method::Collocation => 1e-7 * 0.5_f64.hypot(0.5).hypot(1.0).hypot(1.0),
            // Every step is a part of its own.
            _ => 1e-7 * (5.0 * (2.0 * 0.1_f64.powi(2) + 2.0 * 0.2_f64.powi(2))).sqrt(),
        };
        assert_relative_eq!(uncertainty, expected, max_relative = 1e-12);
        let bar = outcome.error_estimate.mesh.unwrap();
        assert_relative_eq!(
            bar,
            (0.2 * 5e-7 * DURATION).hypot(uncertainty),
            max_relative = 1e-12
        );
        let removed = outcome.uncorrected_work() - outcome.work;
        let bar = outcome.work_error.mesh.unwrap();
        assert!(removed.abs() > 1e-5);
        assert_relative_eq!(bar, 0.2 * removed.abs(), max_relative = 1e-9);
    }
}

#[test]
fn an_error_of_the_angular_velocity_changes_the_displacements_as_estimated() {
    let error = Twist {
        linear: Vector3::zeros(),
        angular: Vector3::new(0.5e-5, -1e-5, 2e-5),
    };
    for (method, tolerance) in [
        (Method::Collocation, 0.05),
        // The rotation within a step is neglected: a quarter of a phase span's displacement in four
        // steps.
        (Method::Euler { steps: 20 }, 0.05),
    ] {
        let exact = follow(&mut Erring::new(&stroke(), Twist::default()), method);
        let mut erring = Erring::new(&stroke(), error);
        let corrected = follow(&mut erring, method);
        for (found, exact) in corrected.displacement.iter().zip(&exact.displacement) {
            assert!((found - exact).norm() < 1e-12);
        }
        let estimated = corrected.mesh_error.unwrap();
        erring.is_corrected = false;
        let outcome = follow(&mut erring, method);
        let pairs = outcome.displacement.iter().zip(&exact.displacement);
        for (body, ((found, exact), estimated)) in pairs.zip(&estimated).enumerate() {
            let difference = found - exact;
            assert!(difference.norm() > 1e-5, "{body}: {difference}");
            assert!(
                (difference - estimated).norm() <= tolerance * difference.norm(),
                "{method:?}, body {body}: {difference} {estimated}"
            );
        }
    }
}

#[test]
fn the_tolerance_limits_all_bars_of_a_model_that_controls_its_error() {
    let mut model = Erring::new(&stroke(), Twist::default());
    // All bars of the model together are between the tolerance of 1e-6 times the net displacement
    // of 0.16 and the tolerance itself.
    model.bars.model = Some(4e-7 / DURATION);
    for controls_error in [false, true] {
        model.controls_error = controls_error;
        let outcome = follow(&mut model, Method::Collocation);
        let bars = &outcome.error_estimate;
        let limited = match controls_error {
            true => bars.total(),
            false => bars.integration.unwrap(),
        };
        assert_eq!(outcome.limited_error, Some(limited));
        assert_eq!(outcome.tolerance_met, !controls_error, "{limited:e}");
    }
}

#[test]
fn the_reference_of_a_stroke_without_net_displacement_is_its_longest_phase() {
    let mut outcome = follow(
        &mut Erring::new(&stroke(), Twist::default()),
        Method::Collocation,
    );
    assert_eq!(outcome.reference_displacement(), outcome.net());
    outcome.displacement = vec![Vector3::x() * 1e-9; 3];
    outcome.error_estimate.model = Some(1e-6);
    for (span, size) in outcome.spans.iter_mut().zip([0.3, 0.9, 0.5, 0.1]) {
        span.displacement = vec![Vector3::y() * size, Vector3::zeros(), Vector3::x() * 0.05];
    }
    assert_eq!(outcome.reference_displacement(), 0.9);
}
