//! Finite elements in unbounded fluid, against exact values.

use std::f64::consts::PI;

use swimmer::models::{FemModel, Hydrodynamics, InstantaneousSolution};
use testkit::{SceneText, chain, start, start_by, start_resistance, within};

/// Unit spheres on the x axis, each under a unit force, by finite elements.
fn spheres(places: &[f64], settings: &[&str]) -> SceneText {
    let text = places
        .iter()
        .enumerate()
        .fold(SceneText::new(), |text, (k, &x)| {
            text.shape(
                &format!("s{k}"),
                "radius = 1, force = [1, 0, 0]",
                [x, 0.0, 0.0],
            )
        });
    text.with("model.kind", "fem").set(settings)
}

/// The velocities are those of multipoles within the bar, which is below `largest` of them.
fn assert_as_multipoles(text: &SceneText, body: usize, largest: f64) -> [InstantaneousSolution; 2] {
    let [exact, found] =
        ["multipole", "fem"].map(|kind| start(&text.clone().model(kind, 1e-8).scene()));
    let speed = exact.bodies[body].velocity.norm();
    let off = (found.bodies[body].velocity - exact.bodies[body].velocity).norm();
    let bar = found.error_estimate.total();
    let why = format!(
        "bars of single solutions are 0.7 to 1.4 of the errors: {}",
        text.toml()
    );
    within(off, 1.4 * bar, why);
    within(bar, largest * speed, "the bar says something");
    [exact, found]
}

#[test]
fn a_pulled_sphere_has_the_drag_of_stokes() {
    let instant = start(&spheres(&[0.0], &["fem.target=5e-4"]).scene());
    let speed = instant.bodies[0].velocity.x;
    let error = 6.0 * PI * speed - 1.0;
    // The effect of the ball, 5/2 / 60^3, is below 2e-5.
    let bar = 6.0 * PI * instant.error_estimate.total();
    within(error, 5e-4, "the target");
    within(error, bar, "the error bar");
    let container = instant.error_estimate.container.unwrap();
    within(container, 2e-5 * speed, "the effect of the ball");
    assert!(instant.dofs.total < 100_000, "{}", instant.dofs.total);
}

#[test]
fn two_spheres_fall_together_as_in_unbounded_fluid() {
    // Stimson & Jeffery 1926: force over 6 pi U at a distance of four.
    let exact = 1.0 / (6.0 * PI * 0.742_258_285_1);
    let instant = start(&spheres(&[-2.0, 2.0], &[]).scene());
    let speed = instant.bodies[0].velocity.x;
    let bar = instant.error_estimate.total();
    within(
        speed - exact,
        1.4 * bar,
        "bars of single solutions are 0.7 to 1.4 of the errors",
    );
    // Without the correction the effect of the ball would be 3 F / (8 pi R), a hundred times as
    // much.
    assert!(bar < 1e-2 * speed);
}

#[test]
fn the_resistance_is_that_of_unbounded_fluid() {
    let scene = spheres(&[0.0], &["fem.size_factor=1.5"]).scene();
    let mut model = FemModel::new(&scene).unwrap();
    let moving = start_by(&mut model);
    let resistance = swimmer::start_resistance(&scene, &mut model).unwrap();
    let off = 1.0 / resistance[(0, 0)] - moving.bodies[0].velocity.x;
    let correction = moving.mesh_error.unwrap().bodies[0].velocity.x.abs();
    within(off, 0.02 * correction, "the accuracy of the corrections");
    // The far field of a torque is negligible.
    within(
        resistance[(3, 3)] / (8.0 * PI) - 1.0,
        2e-2,
        "the discretisation error",
    );
    assert_eq!(model.name(), "fem");
}

#[test]
fn bug_a_fixed_body_was_moved_by_the_far_field_correction() {
    // Multipoles give the exact velocities and forces.
    let text = chain(&["obstacle", "pulled"], &[0.0, 4.0]);
    let text = text.set(&[
        "bodies.obstacle.fixed=true",
        "bodies.pulled.force=[1, 0.5, 0]",
    ]);
    let [exact, found] = assert_as_multipoles(&text, 1, 5e-3);
    let speed = exact.bodies[1].velocity.norm();
    within(
        found.bodies[0].velocity.norm(),
        1e-6 * speed,
        "a fixed body, to the residual",
    );
    let off = (found.bodies[0].force - exact.bodies[0].force).norm();
    within(
        off,
        2e-3 * exact.bodies[0].force.norm(),
        "the default accuracy",
    );
}

#[test]
fn above_a_plane_wall_elements_agree_with_multipoles() {
    // One sphere with two, one or no symmetry planes beside the wall, and a pair with an obstacle;
    // gaps of 0.2 radii and more.
    let one = |position: [f64; 3], force: [f64; 3]| {
        SceneText::new().shape("a", &format!("radius = 1, force = {force:?}"), position)
    };
    let pair = one([0.3, 0.1, 3.0], [1.0, 0.0, 0.5]);
    for text in [
        one([0.0, 0.0, 1.5], [0.0, 0.0, 1.0]),
        one([0.0, 0.0, 1.2], [1.0, 0.0, 0.0]),
        pair.shape("b", "radius = 0.7, fixed = true", [2.3, 0.9, 2.0]),
    ] {
        assert_as_multipoles(&text.with("domain.kind", "wall"), 0, 8e-3);
    }
}

#[test]
#[ignore = "slow: 4 s"]
fn the_resistance_above_a_plane_wall_is_that_of_multipoles() {
    let text = SceneText::new()
        .sphere("a", 1.0, [0, 0, 2])
        .with("domain.kind", "wall");
    let [found, exact] = ["fem", "multipole"]
        .map(|kind| start_resistance(&text.clone().with("model.kind", kind).scene()));
    for row in 0..6 {
        let why = "the default size has errors of 3e-3 in drags, 1e-2 in torques";
        within(found[(row, row)] / exact[(row, row)] - 1.0, 1e-2, why);
    }
}
