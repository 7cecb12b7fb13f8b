//! A priori errors of quadratic elements for the flow around a sphere, from which tolerances
//! follow.
//!
//! The error of the consistent force is the energy of the velocity error, `F_h - F = a(e, e)` up to
//! pressure terms, since the adjoint solution of this functional is the flow itself. The energy is
//! at most a small multiple of the energy of the interpolation error on the same mesh (Céa's
//! lemma), and for one sphere at the centre of a ball the exact flow is known.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use mesh::TetMesh;
use mesher::GenerateParams;
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};
use swimmer::choose;
use swimmer::models::Configuration;

use crate::reference::{concentric_drag, concentric_torque};
use crate::scenes::loaded_sphere;

/// Factor on the energy of the interpolation error.
///
/// The solution is the best approximation among discretely divergence-free velocities only, and the
/// pressure has an error too.
const ALLOWANCE: f64 = 2.0;

/// Relative tolerances for drag and torque of a sphere.
#[derive(Clone, Copy, Default)]
pub struct Tolerances {
    pub drag: f64,
    pub torque: f64,
}

/// Tolerances for a unit sphere with elements of `size` at the centre of a ball of radius
/// `1 / lambda`.
///
/// They are twice the energy of the interpolation error, on the mesh that a scene gets.
pub fn sphere(size: f64, lambda: f64) -> Result<Tolerances> {
    let mesh = ball_in_ball(size, lambda)?;
    let (drag, torque) = (concentric_drag(lambda), concentric_torque(lambda));
    let [a, b, c, d] =
        translation(1.0 / lambda).context("the ball is as small as the sphere inside")?;
    let e = Vector3::x();
    let translating = |r: Vector3<f64>| {
        let (n, along) = (r.norm(), r * e.transpose() + r.x * Matrix3::identity());
        let (across, out) = (e * r.transpose(), r.x * r * r.transpose());
        let velocity = (a / n + b / n.powi(3) + c + 2.0 * d * n * n) * e
            + r.x * (a / n.powi(3) - 3.0 * b / n.powi(5) - d) * r;
        let gradient = (4.0 * d - a / n.powi(3) - 3.0 * b / n.powi(5)) * across
            + (a / n.powi(3) - 3.0 * b / n.powi(5) - d) * along
            + (15.0 * b / n.powi(7) - 3.0 * a / n.powi(5)) * out;
        (velocity, gradient)
    };
    let spin = Vector3::z().cross_matrix();
    let turning = |r: Vector3<f64>| {
        let n = r.norm();
        let rate = torque / n.powi(3) + 1.0 - torque;
        let gradient = rate * spin - 3.0 * torque / n.powi(5) * spin * r * r.transpose();
        (rate * (spin * r), gradient)
    };
    Ok(Tolerances {
        drag: ALLOWANCE * interpolation_energy(&mesh, translating)? / (6.0 * PI * drag),
        torque: ALLOWANCE * interpolation_energy(&mesh, turning)? / (8.0 * PI * torque),
    })
}

/// Coefficients of the flow around a sphere in a concentric ball whose radius is `wall`.
///
/// ```text
/// u = A (e/r + x r/r^3) + B (e/r^3 - 3 x r/r^5) + C e + D (2 r^2 e - x r)
/// ```
///
/// The velocity is `e` at `r = 1` and zero at the wall.
fn translation(wall: f64) -> Option<[f64; 4]> {
    let rows = [1.0, wall].map(|r: f64| {
        let radial = [2.0 / r, -2.0 / r.powi(3), 1.0, r * r];
        let tangential = [1.0 / r, 1.0 / r.powi(3), 1.0, 2.0 * r * r];
        [radial, tangential]
    });
    let matrix = Matrix4::from_fn(|i, j| rows[i / 2][i % 2][j]);
    let solution = matrix.lu().solve(&Vector4::new(1.0, 1.0, 0.0, 0.0))?;
    Some(solution.into())
}

/// Energy of the interpolation error, `∫ |∇(u - I_h u)|^2`.
fn interpolation_energy(
    mesh: &TetMesh,
    flow: impl Fn(Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) + Sync,
) -> Result<f64> {
    let velocity: Vec<_> = mesh.points().iter().map(|&x| flow(x).0).collect();
    Ok(fem::field_error(mesh, &velocity, flow)?.h1_seminorm.powi(2))
}

fn ball_in_ball(size: f64, lambda: f64) -> Result<TetMesh> {
    let scene = loaded_sphere(lambda, size)?;
    let state = scene.initial_state();
    let configuration = Configuration::new(&state, &[]);
    let mut model = choose(&scene)?.model;
    model.mesh(configuration)?.context("the model has no mesh")
}

/// Estimated error on the finer of two meshes, for a method of second order or better.
///
/// It is a third of the change from the mesh with elements of twice the size. The elements have to
/// be larger by this factor everywhere, not on the surfaces alone.
pub fn from_halving(coarse: f64, fine: f64) -> f64 {
    (coarse - fine).abs() / 3.0
}

/// Constant `κ^2` of the interpolation error on a regular tetrahedron with edges `h`.
///
/// `|∇(u - I_h u)|^2 = κ^2 h^4 |∇^3 u|^2`, as a mean over the tetrahedron and over isotropic
/// tensors of third derivatives, by Gauss quadrature of the interpolation error of cubics.
const REGULAR_INTERPOLATION: f64 = 4.93e-4;

/// Error of the force on two unit spheres that approach each other, over `6 pi U`, from elements in
/// their gap.
///
/// Only those elements count that the gap keeps smaller than `size`: a mesh with half the surface
/// size does not refine them. In a gap of width `H = gap + rho^2` the flow is, to leading order,
///
/// ```text
/// u_x = 3 U x / (2 H) (1 - 4 z^2 / H^2)      (u_y alike)
/// u_z = -3 U / H (z - 4 z^3 / (3 H^2))
/// |∇^3 u|^2 = (24^2 + 6 · 12^2) U^2 / H^6
/// ```
///
/// Element sizes are a fixed fraction of `H`. The power is `2 U` times the force.
pub fn gap(gap: f64, size: f64) -> f64 {
    let part = GenerateParams::default().gap;
    let widest = size / part;
    if widest <= gap {
        return 0.0;
    }
    // Integral of `(part H)^4 1440 / H^6` over `H pi dH`.
    let energy = REGULAR_INTERPOLATION * part.powi(4) * 1440.0 * PI * (widest / gap).ln();
    ALLOWANCE * energy / (2.0 * 6.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_flow_is_that_of_happel_and_brenner() {
        for lambda in [0.1_f64, 0.5] {
            let [a, b, ..] = translation(1.0 / lambda).unwrap();
            let k = concentric_drag(lambda);
            let dipole = 0.25 * k * (1.0 - lambda.powi(3)) / (1.0 - lambda.powi(5));
            assert!((a / (0.75 * k) - 1.0).abs() < 1e-12);
            assert!((b / dipole - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn tolerances_fall_with_the_mesh_faster_than_its_second_power() {
        let [coarse, fine] = [0.4, 0.2].map(|size| sphere(size, 0.5).unwrap());
        assert!(coarse.drag / fine.drag > 4.0 && coarse.torque / fine.torque > 4.0);
        // A wrong gradient would show as an energy of the order of the dissipation.
        assert!(fine.drag < 1e-2 && fine.torque < 1e-2);
    }

    #[test]
    fn a_wide_gap_has_no_error_of_its_own() {
        assert_eq!(gap(1.0, 0.4), 0.0);
        assert!(gap(0.1, 0.4) > gap(0.5, 0.4));
    }
}
