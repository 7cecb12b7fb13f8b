//! Runs in background flows, with slip and with gravity.

use std::f64::consts::PI;

use swimmer::{Method, choose, with_tables};
use testkit::{SceneText, boxed, run, run_by, start, start_by, within};

/// A template of the command `swim new`.
fn template(text: &str) -> swimmer::Scene {
    SceneText::file(text).scene()
}

/// Gravity: the weight is the excess of the density times the volume.
#[test]
fn spheres_settle_with_the_velocity_of_stokes() {
    let text = SceneText::new().shape("s", "radius = 0.5, density = 4", [0; 3]);
    let text = text.set(&["gravity=[0, 0, -9]", "fluid.viscosity=2", "fluid.density=3"]);
    let solution = start(&text.scene());
    // U = 2 a^2 (rho - rho_f) g / (9 mu)
    let expected = -2.0 * 0.25 * 9.0 / (9.0 * 2.0);
    within(
        solution.bodies[0].velocity.z - expected,
        1e-9,
        "one sphere needs one multipole",
    );
}

/// Drift angle atan((U1 - U2) / (U1 + U2)) at 45 degrees, with the speeds along and across the axis
/// of Oberbeck's formulas.
#[test]
fn the_settling_template_has_the_exact_drift_angle() {
    let solution = start(&template(include_str!("../../templates/settling.toml")));
    let u = solution.bodies[0].velocity;
    let angle = (u.x.abs() / -u.z).atan().to_degrees();
    within(angle - 3.875_218, 1e-3, "the tolerance of the template");
    let bar = solution.error_estimate.total();
    within(u.y, bar, "the error bar");
    within(bar, 1e-3 * u.norm(), "the tolerance of the template");
}

#[test]
fn auto_takes_multipoles_for_spheres_with_slip_and_elements_for_tumbling_spheroids() {
    let squirmer = template(include_str!("../../templates/squirmer.toml"));
    assert_eq!(boxed(&squirmer).name(), "multipole");
    let jeffery = template(include_str!("../../templates/jeffery.toml"));
    assert_eq!(boxed(&jeffery).name(), "fem");
    let keys = "shape = \"spheroid\", radius = 1, half_length = 2, slip = { b1 = 1 }";
    let text = SceneText::new().shape("s", keys, [0; 3]);
    let flow = "{ kind = \"uniform\", velocity = [1, 0, 0] }";
    let mut model = boxed(&text.with("background", flow).scene());
    assert_eq!(model.name(), "axisymmetric");
    // carried by the flow
    let velocity = start_by(model.as_mut()).bodies[0].velocity.x;
    within(
        velocity - 1.826_436_002_5,
        1e-6,
        "the accuracy in the meridian plane",
    );
}

/// A squirmer alone swims straight at 2 B1 / 3, whatever its second mode.
#[test]
fn a_lone_squirmer_swims_straight() {
    let keys = "radius = 2, slip = { b1 = 1.5, b2 = -4, axis = [0, 1, 0] }";
    let text = SceneText::new()
        .shape("s", keys, [1, 0, 0])
        .phase("duration = 3");
    let outcome = run(&text.scene());
    within(
        outcome.displacement[0].y - 3.0,
        1e-9,
        "one sphere needs two multipoles",
    );
    within(outcome.displacement[0].xz().norm(), 1e-9, "rounding");
    // the dissipation 8 pi a (2 B1^2 + B2^2) / 3 over the duration
    let work = 3.0 * 8.0 * PI * 2.0 * (2.0 * 2.25 + 16.0) / 3.0;
    within(
        outcome.work / work - 1.0,
        1e-6,
        "the quadrature over the sphere",
    );
}

/// Jeffery (1922): the period is 2 pi (r + 1 / r) over the shear rate; half of it turns by pi.
///
/// Solutions are superposed from five orientations, so that a run takes seconds. A spheroid of
/// aspect ratio 10 is a row of `cargo xtask validate`.
#[test]
#[ignore = "slow: 5 s"]
fn jeffery_orbits_have_the_exact_period() {
    let scene = template(include_str!("../../templates/jeffery.toml"));
    let mut model = with_tables(&scene, choose(&scene).unwrap()).unwrap().model;
    let turned = run_by(model.as_mut(), Method::Collocation).rotation.norm();
    within(
        turned - PI,
        1e-3 * 2.0 * PI,
        "the tolerance of the template",
    );
}
