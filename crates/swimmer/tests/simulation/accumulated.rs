//! Errors of the velocities accumulate to errors of the displacements and of the work.

use nalgebra::Vector3;
use rigid::Twist;
use swimmer::models::{Capabilities, DiscretisationError, ErrorEstimate, Uncertainty};
use swimmer::{Method, Outcome, Scene};
use testkit::{Recording, run_by, three_spheres, within};

use crate::support::{Tensor, TestModel};

/// Constant errors of the test model, of which only those of the motion are real.
#[derive(Clone, Copy, Default)]
struct Erring {
    motion: Twist,
    /// Force of the first body.
    force: Vector3<f64>,
    uncertainty: Uncertainty,
    bars: ErrorEstimate,
    spin_bars: ErrorEstimate,
    power_bars: ErrorEstimate,
    controls_error: bool,
    /// Whether the errors stay in the answer, which is exact otherwise.
    is_uncorrected: bool,
}

/// The stroke by the test model with these errors.
fn follow(errors: Erring, method: Method) -> Outcome {
    let exact = TestModel::new(&stroke(), Tensor::Rpy);
    let mut model = Recording::changing(exact, move |_, solutions| {
        for solution in solutions {
            let mut response = &solution.response * 0.0;
            response.motion.frames[0] = errors.motion;
            response.motion.spins.fill(errors.motion.angular);
            response.bodies[0].force = errors.force;
            solution.response += &response;
            solution.error_estimate = errors.bars;
            solution.angular_velocity_error = errors.spin_bars;
            solution.power_error = errors.power_bars;
            if !errors.is_uncorrected {
                let uncertainty = errors.uncertainty;
                solution.correct(DiscretisationError {
                    response,
                    uncertainty,
                });
            }
        }
    });
    model.capabilities = Capabilities {
        controls_error: errors.controls_error,
        ..Capabilities::default()
    };
    run_by(&mut model, method)
}

/// Phases of the durations 1/2, 1/2, 1 and 1.
pub fn stroke() -> Scene {
    let text = three_spheres().tolerance(1e-6);
    text.set(&["gait.phases.0.duration=0.5", "gait.phases.1.duration=0.5"])
        .scene()
}

const DURATION: f64 = 3.0;

#[test]
fn error_bars_of_a_run_are_those_of_the_velocities_times_the_duration() {
    let bars = |unit: f64| ErrorEstimate {
        container: Some(unit),
        model: Some(2.0 * unit),
        algebraic: Some(4.0 * unit),
        ..ErrorEstimate::default()
    };
    let linear = Vector3::new(3e-7, 0.0, 4e-7);
    let errors = Erring {
        motion: Twist {
            linear,
            ..Twist::default()
        },
        // An error of one body, whose power is far from zero.
        force: Vector3::x() * 1e-3,
        uncertainty: Uncertainty {
            relative: 0.2,
            velocity: 1e-7,
            angular_velocity: 1e-8,
            ..Uncertainty::default()
        },
        bars: bars(1e-6),
        spin_bars: bars(1e-9),
        power_bars: bars(1e-5),
        ..Erring::default()
    };
    let close = |found: f64, expected: f64, bound: f64, what: &str| {
        within(found / expected - 1.0, bound, what);
    };
    for method in [Method::Collocation, Method::Euler { steps: 5 }] {
        let outcome = follow(errors, method);
        for (found, unit) in [
            (&outcome.error_estimate, 1e-6),
            (&outcome.rotation_error, 1e-9),
            (&outcome.work_error, 1e-5),
        ] {
            let expected = bars(unit * DURATION);
            for (found, expected) in [
                (found.container, expected.container),
                (found.model, expected.model),
                (found.algebraic, expected.algebraic),
            ] {
                close(
                    found.unwrap(),
                    expected.unwrap(),
                    1e-13,
                    "rounding of a sum",
                );
            }
        }
        for (span, duration) in outcome.spans.iter().zip([0.5, 0.5, 1.0, 1.0]) {
            let found = span.error_estimate.model.unwrap();
            close(found, 2e-6 * duration, 1e-13, "rounding of a sum");
            let found = span.error_estimate.mesh.unwrap();
            assert!(
                (1e-7 * duration..1.5e-7 * duration).contains(&found),
                "{found:e}"
            );
        }
        // Errors of known sign are summed with their signs, uncertainties on one mesh as they are.
        for found in outcome.mesh_error.as_ref().unwrap() {
            let exact = linear * DURATION;
            within(
                (found - exact).norm(),
                1e-13 * exact.norm(),
                "rounding of a sum",
            );
        }
        let uncertainty = outcome.accumulated_error.as_ref().unwrap().uncertainty;
        let expected = match method {
            // Within a phase span they are summed, phase spans are independent.
            Method::Collocation => 1e-7 * 0.5_f64.hypot(0.5).hypot(1.0).hypot(1.0),
            // Every step is a part of its own.
            _ => 1e-7 * (5.0 * (2.0 * 0.1_f64.powi(2) + 2.0 * 0.2_f64.powi(2))).sqrt(),
        };
        close(uncertainty, expected, 1e-12, "rounding of square roots");
        let bar = outcome.error_estimate.mesh.unwrap();
        let expected = (0.2 * 5e-7 * DURATION).hypot(uncertainty);
        close(bar, expected, 1e-12, "rounding of square roots");
        // The rotation has no error, but an uncertainty of a tenth of that of the displacement.
        let bar = outcome.rotation_error.mesh.unwrap();
        close(bar, 0.1 * uncertainty, 1e-12, "rounding of square roots");
        let removed = outcome.uncorrected_work() - outcome.work;
        let bar = outcome.work_error.mesh.unwrap();
        assert!(removed.abs() > 1e-5);
        close(
            bar,
            0.2 * removed.abs(),
            1e-9,
            "a difference of works of about 900",
        );
    }
}

#[test]
fn an_error_of_the_angular_velocity_changes_the_displacements_as_estimated() {
    let angular = Vector3::new(0.5e-5, -1e-5, 2e-5);
    let motion = Twist {
        angular,
        ..Twist::default()
    };
    let erring = Erring {
        motion,
        ..Erring::default()
    };
    for method in [Method::Collocation, Method::Euler { steps: 20 }] {
        let exact = follow(Erring::default(), method);
        let corrected = follow(erring, method);
        for (found, exact) in corrected.displacement.iter().zip(&exact.displacement) {
            within(
                (found - exact).norm(),
                1e-12,
                "rounding: the error is subtracted",
            );
        }
        let estimated = corrected.mesh_error.unwrap();
        let outcome = follow(
            Erring {
                is_uncorrected: true,
                ..erring
            },
            method,
        );
        let pairs = outcome.displacement.iter().zip(&exact.displacement);
        for (body, ((found, exact), estimated)) in pairs.zip(&estimated).enumerate() {
            let difference = found - exact;
            assert!(difference.norm() > 1e-5, "{body}: {difference}");
            // The Euler method neglects the rotation within a step: a quarter of a phase span's
            // displacement in four steps.
            let why = format!("second order and steps; {method:?}, body {body}");
            within(
                (difference - estimated).norm(),
                0.05 * difference.norm(),
                why,
            );
        }
    }
}

#[test]
fn the_tolerance_limits_all_bars_of_a_model_that_controls_its_error() {
    // All bars of the model together are between the tolerance of 1e-6 times the net displacement
    // of 0.16 and the tolerance itself.
    let model = Some(4e-7 / DURATION);
    let bars = ErrorEstimate {
        model,
        ..ErrorEstimate::default()
    };
    for controls_error in [false, true] {
        let errors = Erring {
            bars,
            controls_error,
            ..Erring::default()
        };
        let outcome = follow(errors, Method::Collocation);
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
    let mut outcome = follow(Erring::default(), Method::Collocation);
    assert_eq!(outcome.reference_displacement(), outcome.net());
    outcome.displacement = vec![Vector3::x() * 1e-9; 3];
    outcome.error_estimate.model = Some(1e-6);
    for (span, size) in outcome.spans.iter_mut().zip([0.3, 0.9, 0.5, 0.1]) {
        span.displacement = vec![Vector3::y() * size, Vector3::zeros(), Vector3::x() * 0.05];
    }
    assert_eq!(outcome.reference_displacement(), 0.9);
}
