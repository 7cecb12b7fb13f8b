//! Small scenes, and how far two answers to the same question may be apart.

use nalgebra::Vector3;
use swimmer::choose;
use swimmer::models::{Configuration, FlowField, InstantaneousSolution};
use swimmer::{Scene, solve_start};

/// Options of every scene here: coarse, but solved well beyond the mesh's accuracy.
pub const COARSE: &str = "model.kind = \"fem\"\nfem.surface_size = 0.7\nfem.rtol = 1e-10\n";

/// Three spheres of different sizes on two arms at an angle, off the centre of a ball: no symmetry to hide behind.
pub const BODIES: &str = r#"
[[bodies]]
name = "left"
radius = 1
position = [-4, 1, 0.5]
[[bodies]]
name = "centre"
radius = 1.25
position = [0, 0, 1]
[[bodies]]
name = "right"
radius = 1
position = [3, 3, 0]
[[links]]
name = "left-arm"
body = "left"
to = "centre"
[[links]]
name = "right-arm"
body = "right"
to = "centre"
"#;

pub const BALL: &str = "domain = { kind = \"ball\", radius = 12 }\n";

/// The bent swimmer with its left arm closing by one in one unit of time.
pub fn bent(options: &str) -> Scene {
    let gait = "[[gait.phases]]\nlink = \"left-arm\"\nlength = 3.25\n";
    parse(&format!("{BALL}{options}{BODIES}{gait}"))
}

pub fn parse(text: &str) -> Scene {
    Scene::parse(text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The first instant of a scene.
pub fn solve(scene: &Scene) -> InstantaneousSolution {
    solve_with_flow(scene).0
}

pub fn solve_with_flow(scene: &Scene) -> (InstantaneousSolution, FlowField) {
    let mut model = choose(scene).unwrap().model;
    let instant = solve_start(scene, model.as_mut()).unwrap();
    let flow = model.last_flow().unwrap();
    (instant, flow)
}

/// The mesh of a scene's start.
pub fn mesh(scene: &Scene) -> mesh::TetMesh {
    let lengths = scene.articulation().initial_lengths();
    let state = scene.initial_state();
    let configuration = Configuration {
        state: &state,
        lengths,
    };
    let mut model = choose(scene).unwrap().model;
    model.mesh(configuration).unwrap().unwrap()
}

/// Bound on the norm of a system's right-hand side, viscosity 1 and radii about 1.
///
/// Its entries are the nodal forces of spheres that move while every other node is held: a shear layer half an element
/// thick, where the drag has one of 2/3 of a radius. That is at most four times the forces of the flow from `h` = 0.35 up,
/// and a norm is at most a sum; incompressibility adds the sphere's flux, below its area. Ten covers both.
pub fn right_side(instant: &InstantaneousSolution) -> f64 {
    let loads = instant
        .bodies
        .iter()
        .map(|b| b.force.norm() + b.torque.norm());
    10.0 * loads.sum::<f64>()
}

/// Error that the solve leaves in a velocity, viscosity 1 and radii about 1.
///
/// For a residual `r` it is `x . r`, `x` the solution for a unit load on that velocity. No node of `x` moves faster than the
/// pulled sphere, `1 / 6 pi`, nor is a pressure larger than on it, `3/2 / 6 pi`: `|x| <= sqrt(dofs) / 4 pi`.
pub fn velocity_error(instant: &InstantaneousSolution) -> f64 {
    // Below the rounding of sums over all unknowns a reported residual means nothing.
    let residual = instant.solver.true_relative_residual.max(1e-14);
    residual * right_side(instant) * (instant.dofs.total as f64).sqrt()
        / (4.0 * std::f64::consts::PI)
}

/// Error that the solve leaves in a force or torque: that of the velocity times the largest resistance, which is at
/// most twice the torque of the largest sphere here, `8 pi 1.25^3`.
pub fn force_error(instant: &InstantaneousSolution) -> f64 {
    100.0 * velocity_error(instant)
}

/// The answers with their motion and loads, one after the other: velocities, then loads.
pub fn largest_differences(
    a: &InstantaneousSolution,
    b: &InstantaneousSolution,
    map: impl Fn([Vector3<f64>; 4]) -> [Vector3<f64>; 4],
) -> [f64; 2] {
    let mut largest = [0.0_f64; 2];
    for (a, b) in a.bodies.iter().zip(&b.bodies) {
        let expected = map([a.velocity, a.angular_velocity, a.force, a.torque]);
        let found = [b.velocity, b.angular_velocity, b.force, b.torque];
        for (k, (e, f)) in expected.iter().zip(&found).enumerate() {
            largest[k / 2] = largest[k / 2].max((e - f).norm());
        }
    }
    largest
}
