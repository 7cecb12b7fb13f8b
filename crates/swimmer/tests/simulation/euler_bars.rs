//! Error bars of the explicit Euler method against known strokes.

use std::path::Path;

use crate::support::{STROKE, Tensor, TestModel, run_with, scene, three_spheres};
use nalgebra::Vector3;
use swimmer::choose;
use swimmer::models::Hydrodynamics;
use swimmer::{Method, Outcome, Scene, simulate};

fn follow(scene: &Scene, model: &mut dyn Hydrodynamics, method: Method) -> Outcome {
    simulate(scene, model, method, &mut ()).unwrap()
}

/// The largest integration error of a displacement, its error bar, and the uncertainty of the
/// estimate.
fn integration_error(text: &str, steps: usize) -> [f64; 3] {
    let mut scene = scene(text);
    let mut model = TestModel::new(&scene, Tensor::Rpy);
    let euler = follow(&scene, &mut model, Method::Euler { steps });
    scene = scene.with_tolerance(1e-10).unwrap();
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
fn check(name: &str, text: &str) {
    for steps in [2, 3, 4, 10, 30] {
        let [error, bar, uncertainty] = integration_error(text, steps);
        println!(
            "{name}, {steps} steps: error {error:.2e}, bar {bar:.2e}, uncertainty {uncertainty:.1e}"
        );
        assert!(
            error <= 1.1 * bar,
            "{name}, {steps}: {error:.3e} > {bar:.3e}"
        );
        if error > uncertainty {
            let ratio = bar / error;
            assert!((0.7..1.4).contains(&ratio), "{name}, {steps}: {ratio}");
        }
    }
}

const FREE: &str = "{ kind = \"unbounded\" }";

fn over_wall(height: f64) -> String {
    three_spheres("", "{ kind = \"wall\" }").replace(", 0, 0]", &format!(", 0, {height}]"))
}

/// One arm that closes and opens.
fn there_and_back() -> String {
    let (closing, _) = STROKE
        .split_once("[[gait.phases]]\n        link = \"right-arm\"")
        .unwrap();
    format!("{closing}{}", closing.replace('6', "10"))
}

#[test]
fn bars_of_a_stroke_with_net_displacement() {
    // The errors of the phases cancel by the symmetry of the stroke. The rest is of second order
    // and below the uncertainty.
    check("unbounded", &three_spheres("", FREE));
    check("above a wall", &over_wall(5.0));
    check("near a wall", &over_wall(2.0));
}

#[test]
fn bars_of_a_reciprocal_stroke_are_its_spurious_displacement() {
    for text in [three_spheres("", FREE), over_wall(4.0)] {
        let text = text.replace(STROKE, &there_and_back());
        check("there and back", &text);
        // The errors of closing and opening add up, so the error exceeds the uncertainty.
        let [error, _, uncertainty] = integration_error(&text, 10);
        assert!(error > 10.0 * uncertainty);
    }
}

#[test]
fn bars_of_a_swimmer_that_rotates() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/planar-three-sphere.toml");
    let text = std::fs::read_to_string(file).unwrap();
    let text = text.replace("{ kind = \"ball\", radius = 40 }", FREE);
    check("planar", &text);
    // The error of the rotation is estimated too.
    let scene = scene(&text);
    let follow = |method| follow(&scene, &mut TestModel::new(&scene, Tensor::Rpy), method);
    let exact = follow(Method::Collocation);
    let euler = follow(Method::Euler { steps: 10 });
    let (error, accumulated) = (
        euler.rotation - exact.rotation,
        euler.accumulated_integration_error.unwrap(),
    );
    println!(
        "{error} {} {}",
        accumulated.rotation[0], accumulated.uncertainty
    );
    assert!((accumulated.rotation[0] - error).norm() < 0.3 * error.norm());
}

#[test]
fn bars_contain_the_exact_net_displacement() {
    // Spectral, in a ball of 40 radii and in unbounded fluid.
    for (domain, exact) in [
        ("{ kind = \"ball\", radius = 40 }", 0.1604180159643671),
        (FREE, 0.1598053404),
    ] {
        let text = three_spheres("model = { kind = \"multipole\", tolerance = 1e-5 }", domain);
        let scene = scene(&text);
        let mut model = choose(&scene).unwrap().model;
        let outcome = follow(&scene, model.as_mut(), Method::Euler { steps: 6 });
        let error = (outcome.displacement[1] - Vector3::x() * exact).norm();
        let bar = outcome.error_estimate.total();
        assert!(error <= bar && bar < 0.01 * exact, "{error:.2e} {bar:.2e}");
        // A method with an error bar can meet a tolerance or miss it.
        assert_eq!(
            outcome.tolerance_met,
            outcome.error_estimate.integration.unwrap() <= 1e-5 * outcome.net()
        );
    }
}

#[test]
fn a_single_step_has_no_error_estimate() {
    let scene = scene(&three_spheres("", FREE));
    let mut model = TestModel::new(&scene, Tensor::Rpy);
    let outcome = follow(&scene, &mut model, Method::Euler { steps: 1 });
    assert_eq!(outcome.error_estimate.integration, None);
    assert!(!outcome.tolerance_met);
}
