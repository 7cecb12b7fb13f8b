//! A translating and rotating sphere at the centre of a ball, against exact values.

use std::f64::consts::PI;

use testkit::SceneText;
use testkit::exact::{concentric_drag, concentric_torque};

use crate::scenes::solve_with_flow;

/// Ratio of the radii.
const LAMBDA: f64 = 0.25;

struct Loads {
    drag: f64,
    torque: f64,
    /// Radius of a sphere with the volume of the discrete one.
    radius: f64,
}

fn loads(size: f64, geometry: &str) -> Loads {
    let keys = "radius = 1, force = [1, 0, 0], torque = [0, 0, 1]";
    let text = SceneText::new()
        .shape("s", keys, [0; 3])
        .ball(4.0)
        .elements(size);
    let (instant, flow) = solve_with_flow(&text.with("fem.geometry", geometry).scene());
    let tag = flow.mesh.tag("s").unwrap();
    let volume = fem::surface_measures(&flow.mesh, tag).unwrap().volume;
    Loads {
        drag: 1.0 / instant.bodies[0].velocity.x,
        torque: 1.0 / instant.bodies[0].angular_velocity.z,
        radius: (volume / (4.0 / 3.0 * PI)).cbrt(),
    }
}

fn exact() -> [f64; 2] {
    [
        6.0 * PI * concentric_drag(LAMBDA),
        8.0 * PI * concentric_torque(LAMBDA),
    ]
}

#[test]
fn curved_surfaces_give_drag_and_torque_to_better_than_second_order() {
    let [coarse, fine] = [0.6, 0.3].map(|size| loads(size, "curved"));
    let [drag, torque] = exact();
    for (exact, coarse, fine) in [
        (drag, coarse.drag, fine.drag),
        (torque, coarse.torque, fine.torque),
    ] {
        let error = fine / exact - 1.0;
        // Better than second order: the error is below a third of the change. It is an energy, thus
        // not negative.
        let tolerance = (coarse - fine).abs() / exact / 3.0;
        assert!(error > 0.0 && error < tolerance, "{error:e} {tolerance:e}");
        assert!(tolerance < 1e-2);
    }
}

#[test]
fn straight_facets_give_the_loads_of_the_sphere_of_equal_volume() {
    let straight = loads(0.3, "straight");
    let curved = loads(0.3, "curved");
    let [drag, torque] = exact();
    let deficit = 1.0 - straight.radius;
    // Facets of edge length h are on average h^2 / 8 below the sphere.
    assert!(
        (0.5..1.5).contains(&(deficit / (0.3_f64.powi(2) / 8.0))),
        "{deficit}"
    );
    // Drag is proportional to the radius, torque to its cube. The vertices are outside of the
    // sphere of equal volume, so the decrease is smaller.
    for (exact, straight, curved, power) in [
        (drag, straight.drag, curved.drag, 1.0),
        (torque, straight.torque, curved.torque, 3.0),
    ] {
        let error = straight / exact - 1.0;
        assert!(
            error < 0.0 && error > -2.0 * power * deficit,
            "{error:e} {deficit:e}"
        );
        // Curved elements on the same mesh remove most of the error.
        assert!((curved / exact - 1.0).abs() < 0.5 * error.abs());
    }
    assert!((curved.radius - 1.0).abs() < 0.01 * deficit);
}
