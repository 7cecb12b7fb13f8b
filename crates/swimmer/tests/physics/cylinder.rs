//! Finite elements in an infinite cylinder: the meshed section is closed far from the bodies and
//! follows them.

use swimmer::models::InstantaneousSolution;
use testkit::exact::CYLINDER_5;
use testkit::{SceneText, boxed, pair, run, start_by, within};

const PULLED: f64 = 3.0;

/// A pulled sphere of radius 1/2 in a cylinder of radius 5/2.
fn pulled(size: &[&str], position: [f64; 3], force: [f64; 3]) -> InstantaneousSolution {
    let text = SceneText::new().sphere("s", 0.5, position).set(size);
    let text = text.with("bodies.s.force", format!("{force:?}"));
    let settings = [
        "domain.kind=cylinder",
        "domain.radius=2.5",
        "fluid.viscosity=2",
    ];
    let mut model = boxed(&text.with("model.kind", "fem").set(&settings).scene());
    assert_eq!(model.name(), "fem");
    start_by(model.as_mut())
}

/// Haberman & Sayre (1958), by a collocation of their series to 1e-9.
#[test]
fn drag_on_the_axis_is_exact_within_the_error_bar() {
    let exact = PULLED / (6.0 * std::f64::consts::PI * 2.0 * 0.5 * CYLINDER_5.value);
    for x in [0.0, 70.0] {
        let instant = pulled(&[], [x, 0.0, 0.0], [PULLED, 0.0, 0.0]);
        let off = (instant.bodies[0].velocity.x - exact).abs();
        let bars = instant.error_estimate;
        within(
            off,
            4e-3 * exact,
            "elements of 0.4 radii have an error of 3e-3 in the drag",
        );
        within(
            off,
            bars.total() / 0.7,
            "bars of single solutions are at least 0.7 of the errors",
        );
        within(
            bars.container.unwrap(),
            2e-9 * exact,
            "the ends are far away",
        );
    }
}

/// The position along the cylinder and the side do not matter.
#[test]
#[ignore = "slow: 4 s"]
fn equivalent_positions_give_equal_speeds_off_the_axis() {
    let coarse = &["fem.surface_size=0.5"];
    let along = |position| pulled(coarse, position, [PULLED, 0.0, 0.0]);
    let first = along([0.0, 1.2, 0.0]);
    let bar = first.error_estimate.total();
    for (position, other) in [
        ([13.0, 1.2, 0.0], along([13.0, 1.2, 0.0])),
        ([0.0, 0.0, -1.2], along([0.0, 0.0, -1.2])),
    ] {
        let apart = (first.bodies[0].velocity.x - other.bodies[0].velocity.x).abs();
        within(apart, 2.0 * bar, format!("both error bars: {position:?}"));
    }
    // Halfway to the wall a sphere is slightly faster than on the axis (Happel & Brenner 1983,
    // section 7-3).
    let middle = along([0.0; 3]);
    assert!(first.bodies[0].velocity.x > middle.bodies[0].velocity.x);
    // A sphere near a wall rotates as if rolling on it, and its distance stays constant.
    assert!(first.bodies[0].angular_velocity.z.abs() > 0.01 * first.bodies[0].velocity.x);
    within(first.bodies[0].velocity.y, bar, "the error bar");
    let [y, z] = [[0.0, PULLED, 0.0], [0.0, 0.0, PULLED]].map(|f| pulled(coarse, [0.0; 3], f));
    let apart = (y.bodies[0].velocity.y - z.bodies[0].velocity.z).abs();
    within(apart, 2.0 * y.error_estimate.total(), "both error bars");
}

/// The meshed section follows bodies that leave it.
#[test]
fn the_meshed_section_follows_the_bodies() {
    let text = pair(0.0, 4.0).elements(1.2).tolerance(0.2);
    let text = text.set(&[
        "domain.kind=cylinder",
        "domain.radius=4",
        "fem.estimates=off",
    ]);
    let text = ["a", "b"].iter().zip([0, 4]).fold(text, |text, (body, x)| {
        text.with(&format!("bodies.{body}.position"), format!("[{x}, 1, 0]"))
            .with(&format!("bodies.{body}.force"), "[120, 0, 0]")
    });
    let text = text
        .phase("link = \"arm\", length = 4.2, duration = 6")
        .with("gait.arms", "lab");
    let outcome = run(&text.scene());
    // The first section extends over four radii of the cylinder. At two radii from an end its
    // effect on a velocity is 3e-5.
    let travelled = outcome.displacement[0].x;
    assert!(travelled > 16.0, "{travelled}");
    assert!(outcome.meshes.len() > 1);
    let bar = outcome.error_estimate.container.unwrap();
    within(
        bar,
        3.6e-5 * travelled,
        "the effect of the ends, and a fifth",
    );
}
