//! Derivatives of net displacements against identities and formulas for small amplitudes.

use std::f64::consts::TAU;

use design::sensitivities::{parameters, sensitivities, sensitivity};
use testkit::exact::STROKE;
use testkit::{SceneText, within};

use crate::{smooth, three_sphere};

/// Displacements are proportional to the size of a swimmer without a time scale. By Euler's theorem
/// the sum of all lengths times the derivatives by them is the displacement.
#[test]
fn derivatives_by_all_lengths_sum_to_the_displacement() {
    for (text, exact) in [(three_sphere(), STROKE.value), (smooth(), 0.123_804_673)] {
        let scene = text.tolerance(1e-4).scene();
        let found = sensitivities(&scene, &mut ()).unwrap();
        assert_eq!(found.len(), 7);
        let (mut sum, mut bar) = (0.0, 0.0);
        for sensitivity in &found {
            sum += sensitivity.parameter.value * sensitivity.derivative;
            bar += sensitivity.parameter.value * sensitivity.error;
        }
        within(sum - exact, bar, "the error bar");
        within(bar, 0.01 * exact, "the bar says something");
    }
}

/// `Δ = π A B curl(L)` for arms that oscillate by `A` and `B` about `L`, a quarter of a period
/// apart; `curl(10) = 0.006077339` for spheres of radius 1.
#[test]
fn small_strokes_have_the_derivatives_of_their_formula() {
    let settings = [
        "bodies.left.position=[-10.02, 0, 0]",
        "bodies.right.position=[10, 0, 0]",
        "gait.harmonics.0.mean=10",
        "gait.harmonics.1.mean=10",
        "gait.harmonics.0.amplitude=0.02",
        "gait.harmonics.1.amplitude=0.02",
    ];
    let scene = smooth().set(&settings).tolerance(1e-4).scene();
    let exact = 0.5 * TAU * 0.02 * 0.006_077_339;
    let amplitudes: Vec<_> = (parameters(&scene).unwrap().into_iter())
        .filter(|parameter| parameter.name.starts_with("amplitude"))
        .collect();
    assert_eq!(amplitudes.len(), 2);
    for parameter in amplitudes {
        within(parameter.value - 0.02, 1e-12, "rounding");
        let found = sensitivity(&scene, parameter).unwrap();
        within(
            found.derivative / exact - 1.0,
            1e-4,
            "the next term, of the order of (A / L)^2",
        );
    }
}

/// `Δ ~ k ω / (k^2 + ω^2 G^2)` for an arm that is a spring: the derivative by the stiffness is
/// `Δ / k (1 - 2 / (1 + (ω G / k)^2))`, for a stroke of small amplitude.
#[test]
fn the_stiffness_of_a_spring_has_the_derivative_of_its_formula() {
    // Half of the frequency at which the swimmer is fastest, 0.0714303722.
    let text = SceneText::file(include_str!("../../../swimmer/templates/elastic-arm.toml"));
    let text = text.with("gait.period", TAU / (0.5 * 0.071_430_372_2));
    let scene = text.with("model.kind", "multipole").scene();
    let stiffness = (parameters(&scene).unwrap().into_iter())
        .find(|parameter| parameter.name.starts_with("stiffness"));
    let found = sensitivity(&scene, stiffness.unwrap()).unwrap();
    // Exact displacement at this frequency.
    let exact = 0.003_499_890_6 * (1.0 - 2.0 / 1.25);
    let why = "the formula neglects the square of the amplitude relative to that of the length";
    within(found.derivative / exact - 1.0, 1e-2, why);
}

/// A phase turns by whole turns, or its wave does not close: it is no parameter, amplitudes are.
#[test]
fn phases_of_waves_are_no_parameters() {
    let names = |targets: &str| -> Vec<String> {
        let text = format!(
            "bodies = [{{ name = \"worm\", shape = \"tube\", length = 10, radius = 0.5, \
             position = [0, 0, 0], deformation = {{ kind = \"undulation\", amplitude = 0.4 }} }}]\n\
             [[gait.phases]]\ntargets = {{ {targets} }}\n"
        );
        let scene = swimmer::Scene::parse(&text).unwrap();
        let all = parameters(&scene).unwrap().into_iter();
        all.map(|parameter| parameter.name).collect()
    };
    let turn = format!("\"worm.phase\" = {TAU:?}");
    assert!(names(&turn).is_empty());
    let both = format!("{turn}, \"worm.amplitude\" = 0.6");
    assert_eq!(names(&both), ["amplitude of \"worm.amplitude\""]);
}
