//! Finite elements in an infinite cylinder: the meshed section is closed far from the bodies and
//! follows them.

use swimmer::choose;
use swimmer::models::InstantaneousSolution;
use swimmer::{Method, Scene, simulate, solve_start};

const PULLED: f64 = 3.0;

/// A pulled sphere of radius 1/2 in a cylinder of radius 5/2.
fn pulled(more: &str, position: [f64; 3], force: [f64; 3]) -> InstantaneousSolution {
    let scene = Scene::parse(&format!(
        "model.kind = \"fem\"\ndomain = {{ kind = \"cylinder\", radius = 2.5 }}\nfluid.viscosity = 2\n{more}\n\
         bodies = [{{ name = \"s\", radius = 0.5, position = {position:?}, force = {force:?} }}]"
    ))
    .expect("a scene");
    let mut model = choose(&scene).expect("supported").model;
    assert_eq!(model.name(), "fem");
    solve_start(&scene, model.as_mut()).expect("a solution")
}

/// Haberman & Sayre (1958), by a collocation of their series to 1e-9.
#[test]
fn drag_on_the_axis_is_exact_within_the_error_bar() {
    let exact = PULLED / (6.0 * std::f64::consts::PI * 2.0 * 0.5 * 1.679478884847892);
    for x in [0.0, 70.0] {
        let instant = pulled("", [x, 0.0, 0.0], [PULLED, 0.0, 0.0]);
        let off = (instant.bodies[0].velocity.x - exact).abs();
        let bars = instant.error_estimate;
        // Elements of 0.4 radii have an error of 3e-3 in the drag of a sphere; the error bar should
        // be at least 0.7 of the error.
        assert!(
            off < 4e-3 * exact && off < bars.total() / 0.7,
            "{off:e} {bars:?}"
        );
        assert!(bars.container.is_some_and(|bar| bar < 2e-9 * exact));
    }
}

/// The position along the cylinder and the side do not matter.
#[test]
fn equivalent_positions_give_equal_speeds_off_the_axis() {
    let coarse = "fem.surface_size = 0.5";
    let along = |position| pulled(coarse, position, [PULLED, 0.0, 0.0]);
    let first = along([0.0, 1.2, 0.0]);
    let bar = first.error_estimate.total();
    for (position, other) in [
        ([13.0, 1.2, 0.0], along([13.0, 1.2, 0.0])),
        ([0.0, 0.0, -1.2], along([0.0, 0.0, -1.2])),
    ] {
        let apart = (first.bodies[0].velocity.x - other.bodies[0].velocity.x).abs();
        assert!(apart < 2.0 * bar, "{position:?}: {apart:e} {bar:e}");
    }
    // Halfway to the wall a sphere is slightly faster than on the axis (Happel & Brenner 1983,
    // section 7-3).
    let middle = along([0.0; 3]);
    assert!(first.bodies[0].velocity.x > middle.bodies[0].velocity.x);
    // A sphere near a wall rotates as if rolling on it, and its distance stays constant.
    assert!(first.bodies[0].angular_velocity.z.abs() > 0.01 * first.bodies[0].velocity.x);
    assert!(first.bodies[0].velocity.y.abs() < bar);
    let [y, z] = [[0.0, PULLED, 0.0], [0.0, 0.0, PULLED]].map(|f| pulled(coarse, [0.0; 3], f));
    let apart = (y.bodies[0].velocity.y - z.bodies[0].velocity.z).abs();
    assert!(apart < 2.0 * y.error_estimate.total(), "{apart:e}");
}

/// The meshed section follows bodies that leave it.
#[test]
fn the_meshed_section_follows_the_bodies() {
    let scene = Scene::parse(
        "model = { kind = \"fem\", tolerance = 0.2 }\nfem = { surface_size = 1.2, estimates = \"off\" }\n\
         domain = { kind = \"cylinder\", radius = 4 }\n\
         bodies = [{ name = \"a\", radius = 1, position = [0, 1, 0], force = [120, 0, 0] }, \
                   { name = \"b\", radius = 1, position = [4, 1, 0], force = [120, 0, 0] }]\n\
         links = [{ name = \"arm\", body = \"b\", to = \"a\" }]\ngait.arms = \"lab\"\n\
         gait.phases = [{ link = \"arm\", length = 4.2, duration = 6 }]",
    )
    .expect("a scene");
    let mut model = choose(&scene).expect("supported").model;
    let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ()).expect("a run");
    // The first section extends over four radii of the cylinder. At two radii from an end its
    // effect on a velocity is 3e-5.
    let travelled = outcome.displacement[0].x;
    assert!(travelled > 16.0, "{travelled}");
    assert!(outcome.meshes.len() > 1);
    let bar = outcome.error_estimate.container;
    assert!(bar.is_some_and(|bar| bar < 3.6e-5 * travelled), "{bar:?}");
}
