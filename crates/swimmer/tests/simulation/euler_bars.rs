//! Error bars of the explicit Euler method against known strokes.

use std::path::Path;

use nalgebra::Vector3;
use swimmer::{Method, Scene};
use testkit::{STROKE, boxed, exact, run_by, three_spheres, within};

use crate::strokes::over_wall;
use crate::support::{Tensor, TestModel, run_with};

/// The largest integration error of a displacement, its error bar, and the uncertainty of the
/// estimate.
fn integration_error(scene: &Scene, steps: usize) -> [f64; 3] {
    let mut model = TestModel::new(scene, Tensor::Rpy);
    let euler = run_by(&mut model, Method::Euler { steps });
    let scene = scene.with_tolerance(1e-10).unwrap();
    let exact = run_with(&scene, &mut model, Method::Collocation).unwrap();
    let errors = euler.displacement.iter().enumerate();
    let worst = errors.fold(0.0_f64, |m, (body, d)| m.max((d - exact.net(body)).norm()));
    let uncertainty = euler.accumulated_integration_error.unwrap().uncertainty;
    [
        worst,
        euler.error_estimate.integration.unwrap(),
        uncertainty,
    ]
}

/// Error bars contain the errors, and are close to errors that are larger than the uncertainty.
fn check(name: &str, scene: &Scene) {
    for steps in [2, 3, 4, 10, 30] {
        let [error, bar, uncertainty] = integration_error(scene, steps);
        let what = format!("{name}, {steps} steps, uncertainty {uncertainty:.1e}");
        within(error, 1.1 * bar, &what);
        if error > uncertainty {
            let ratio = bar / error;
            assert!((0.7..1.4).contains(&ratio), "{what}: {ratio}");
        }
    }
}

#[test]
fn bars_of_a_stroke_with_net_displacement() {
    // The errors of the phases cancel by the symmetry of the stroke. The rest is of second order
    // and below the uncertainty.
    check("unbounded", &three_spheres().scene());
    check("above a wall", &over_wall(5.0, 1e-3).scene());
    check("near a wall", &over_wall(2.0, 1e-3).scene());
}

#[test]
fn bars_of_a_reciprocal_stroke_are_its_spurious_displacement() {
    for text in [three_spheres(), over_wall(4.0, 1e-3)] {
        let scene = text
            .without_phases()
            .phases(&[STROKE[0], STROKE[2]])
            .scene();
        check("there and back", &scene);
        // The errors of closing and opening add up, so the error exceeds the uncertainty.
        let [error, _, uncertainty] = integration_error(&scene, 10);
        assert!(error > 10.0 * uncertainty);
    }
}

#[test]
fn bars_of_a_swimmer_that_rotates() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/planar-three-sphere.toml");
    let scene = Scene::read(&file, &["domain={ kind = \"unbounded\" }".to_owned()]).unwrap();
    check("planar", &scene);
    // The error of the rotation is estimated too.
    let follow = |method| run_by(&mut TestModel::new(&scene, Tensor::Rpy), method);
    let (exact, euler) = (
        follow(Method::Collocation),
        follow(Method::Euler { steps: 10 }),
    );
    let error = euler.rotation - exact.rotation;
    let estimated = euler.accumulated_integration_error.unwrap().rotation[0];
    within(
        (estimated - error).norm(),
        0.3 * error.norm(),
        "the next order in ten steps",
    );
}

#[test]
fn bars_contain_the_exact_net_displacement() {
    let text = three_spheres().model("multipole", 1e-5);
    for (text, exact) in [
        (text.clone().ball(40.0), exact::STROKE_IN_BALL_40),
        (text, exact::STROKE),
    ] {
        let outcome = run_by(boxed(&text.scene()).as_mut(), Method::Euler { steps: 6 });
        let error = (outcome.displacement[1] - Vector3::x() * exact.value).norm();
        let bar = outcome.error_estimate.total();
        within(error, bar, "the error bar");
        within(bar, 0.01 * exact.value, "the bar says something");
        // A method with an error bar can meet a tolerance or miss it.
        assert_eq!(
            outcome.tolerance_met,
            outcome.error_estimate.integration.unwrap() <= 1e-5 * outcome.net()
        );
    }
}

#[test]
fn a_single_step_has_no_error_estimate() {
    let mut model = TestModel::new(&three_spheres().scene(), Tensor::Rpy);
    let outcome = run_by(&mut model, Method::Euler { steps: 1 });
    assert_eq!(outcome.error_estimate.integration, None);
    assert!(!outcome.tolerance_met);
}
