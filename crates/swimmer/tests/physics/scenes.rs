//! Small scenes, and bounds on the difference of two solutions of the same problem.

use nalgebra::Vector3;
use swimmer::Scene;
use swimmer::models::{FlowField, InstantaneousSolution};
use testkit::{SceneText, boxed, start};

/// Settings of every scene here: a coarse mesh, and residuals well below the discretisation error.
pub const COARSE_SETTINGS: [&str; 3] = ["model.kind=fem", "fem.surface_size=0.7", "fem.rtol=1e-10"];

/// Three spheres of different sizes on two arms at an angle, off the centre of a ball, without any
/// symmetry; 4.15 and 4.36 long at the start.
pub fn bodies() -> SceneText {
    SceneText::new()
        .sphere("left", 1.0, [-4.0, 1.0, 0.5])
        .sphere("centre", 1.25, [0, 0, 1])
        .sphere("right", 1.0, [3, 3, 0])
        .slide("left-arm", "left", "centre")
        .slide("right-arm", "right", "centre")
        .ball(9.0)
}

/// The bent swimmer with its left arm closing by one in one unit of time.
pub fn bent(options: &[&str]) -> Scene {
    bodies()
        .phases(&[("left-arm", 3.25)])
        .set(&COARSE_SETTINGS)
        .set(options)
        .scene()
}

pub fn solve_with_flow(scene: &Scene) -> (InstantaneousSolution, FlowField) {
    let mut instant = start(scene);
    let flow = instant.flow.take().unwrap().into_field().unwrap();
    (instant, flow)
}

/// The mesh at the start of a scene.
pub fn mesh(scene: &Scene) -> mesh::TetMesh {
    let shape = scene.articulation().initial_shape();
    let state = scene.initial_state();
    let configuration = testkit::at(&state, shape);
    boxed(scene).mesh(configuration).unwrap().unwrap()
}

/// Bound on the norm of the right-hand side of a system with viscosity 1 and radii about 1.
///
/// Its entries are the nodal forces of moving spheres with zero velocity at all other nodes. Their
/// shear layer has a thickness of half an element instead of 2/3 of a radius, so for `h` of 0.35
/// and more they are at most four times the forces of the flow, and the norm is at most their sum.
/// Incompressibility adds the flux of the sphere, below its area. A factor of ten covers both.
pub fn rhs_bound(instant: &InstantaneousSolution) -> f64 {
    let loads = (instant.bodies.iter()).map(|b| b.force.norm() + b.torque.norm());
    10.0 * loads.sum::<f64>()
}

/// Algebraic error of a velocity, for viscosity 1 and radii about 1.
///
/// For a residual `r` it is `x . r` with the solution `x` for a unit load on that velocity. No
/// nodal velocity of `x` exceeds that of the loaded sphere, `1 / 6 pi`, and no pressure exceeds its
/// largest one, `3/2 / 6 pi`, so `|x| <= sqrt(dofs) / 4 pi`.
pub fn velocity_error(instant: &InstantaneousSolution) -> f64 {
    // Residuals below the rounding of sums over all degrees of freedom are meaningless.
    let residual = instant.solver.true_relative_residual.max(1e-14);
    residual * rhs_bound(instant) * (instant.dofs.total as f64).sqrt()
        / (4.0 * std::f64::consts::PI)
}

/// Algebraic error of a force or torque: that of the velocity times the largest resistance, at most
/// twice that of the rotation of the largest sphere here, `8 pi 1.25^3`.
pub fn force_error(instant: &InstantaneousSolution) -> f64 {
    100.0 * velocity_error(instant)
}

/// Largest differences of velocities and of loads between `a`, transformed by `map`, and `b`.
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
