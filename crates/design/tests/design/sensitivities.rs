//! Derivatives of net displacements against identities and formulas for small amplitudes.

use std::f64::consts::TAU;

use design::sensitivities::{parameters, sensitivities, sensitivity};
use swimmer::Scene;
use swimmer::scene::Document;

fn template(text: &str, settings: &[&str]) -> Scene {
    let mut document = Document::parse(text, "scene.toml".as_ref()).unwrap();
    for setting in settings {
        document.set(setting).unwrap();
    }
    Scene::from_document(document).unwrap()
}

/// Displacements are proportional to the size of a swimmer without a time scale. By Euler's theorem
/// the sum of all lengths times the derivatives by them is the displacement.
#[test]
fn derivatives_by_all_lengths_sum_to_the_displacement() {
    // Exact displacements.
    for (text, exact) in [
        (
            include_str!("../../../swimmer/templates/three-sphere.toml"),
            0.159_805_340_4,
        ),
        (
            include_str!("../../../swimmer/templates/smooth.toml"),
            0.123_804_673,
        ),
    ] {
        let scene = template(text, &["model.tolerance=1e-4"]);
        let found = sensitivities(&scene, &mut ()).unwrap();
        assert_eq!(found.len(), 7);
        let (mut sum, mut bar) = (0.0, 0.0);
        for sensitivity in &found {
            sum += sensitivity.parameter.value * sensitivity.derivative;
            bar += sensitivity.parameter.value * sensitivity.error;
        }
        assert!((sum - exact).abs() <= bar, "{sum} {exact} {bar:e}");
        assert!(bar < 0.01 * exact, "{bar:e}");
    }
}

/// `Δ = π A B curl(L)` for arms that oscillate by `A` and `B` about `L`, a quarter of a period
/// apart; `curl(10) = 0.006077339` for spheres of radius 1.
#[test]
fn small_strokes_have_the_derivatives_of_their_formula() {
    let scene = template(
        include_str!("../../../swimmer/templates/smooth.toml"),
        &[
            "bodies.left.position=[-10.02, 0, 0]",
            "bodies.right.position=[10, 0, 0]",
            "gait.harmonics.0.mean=10",
            "gait.harmonics.1.mean=10",
            "gait.harmonics.0.amplitude=0.02",
            "gait.harmonics.1.amplitude=0.02",
            "model.tolerance=1e-4",
        ],
    );
    let exact = 0.5 * TAU * 0.02 * 0.006_077_339;
    let amplitudes: Vec<_> = (parameters(&scene).unwrap().into_iter())
        .filter(|parameter| parameter.name.starts_with("amplitude"))
        .collect();
    assert_eq!(amplitudes.len(), 2);
    for parameter in amplitudes {
        assert!((parameter.value - 0.02).abs() < 1e-12);
        let found = sensitivity(&scene, parameter).unwrap();
        // The next term is of the order of (A / L)^2.
        assert!((found.derivative / exact - 1.0).abs() < 1e-4, "{found:?}");
    }
}

/// `Δ ~ k ω / (k^2 + ω^2 G^2)` for an arm that is a spring: the derivative by the stiffness is
/// `Δ / k (1 - 2 / (1 + (ω G / k)^2))`, for a stroke of small amplitude.
#[test]
fn the_stiffness_of_a_spring_has_the_derivative_of_its_formula() {
    // Half of the frequency at which the swimmer is fastest, 0.0714303722.
    let period = format!("gait.period={:?}", TAU / (0.5 * 0.071_430_372_2));
    let scene = template(
        include_str!("../../../swimmer/templates/elastic-arm.toml"),
        &[&period, "model.kind=multipole"],
    );
    let stiffness = (parameters(&scene).unwrap().into_iter())
        .find(|parameter| parameter.name.starts_with("stiffness"));
    let found = sensitivity(&scene, stiffness.unwrap()).unwrap();
    // Exact displacement at this frequency; the formula neglects the square of the amplitude,
    // relative to that of the length: 1e-2.
    let exact = 0.003_499_890_6 * (1.0 - 2.0 / 1.25);
    assert!(
        (found.derivative / exact - 1.0).abs() < 1e-2,
        "{found:?} {exact}"
    );
}
