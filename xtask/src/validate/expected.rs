//! What error theory expects of quadratic elements on the flow around a sphere: where tolerances come from.
//!
//! The consistent force errs by the energy of the velocity's error, $F_h - F = a(e, e)$ up to pressure terms: the functional
//! is its own dual. The interpolation error of a quadratic element with edges `h` has
//! $|\nabla e|^2 = \kappa^2 h^4 |\nabla^3 u|^2$, and the flow around a sphere at the centre of a ball is known.

use std::f64::consts::PI;

use nalgebra::{Matrix4, Vector4};

use super::reference::{concentric_drag, concentric_torque};

/// $\kappa^2$ of a regular tetrahedron with edges of length 1: mean over the tetrahedron and over isotropic tensors of
/// third derivatives, by Gauss quadrature of the interpolation error of cubics.
const INTERPOLATION: f64 = 4.93e-4;

/// Real tets are not regular (mean quality 0.88, worst 0.4), and the pressure errs too: double what is ideal.
const ALLOWANCE: f64 = 2.0;

/// Tolerance for the drag of a unit sphere, with elements of `size` on it, at the centre of a ball of radius `1 / lambda`:
/// relative, twice what interpolation on regular tets gives.
pub fn drag(size: f64, lambda: f64) -> f64 {
    let wall = 1.0 / lambda;
    // u = A (e/r + x r/r^3) + B (e/r^3 - 3 x r/r^5) + C e + D (2 r^2 e - x r): unit velocity on r = 1, none on the wall.
    let rows = [1.0, wall].map(|r: f64| {
        let radial = [2.0 / r, -2.0 / r.powi(3), 1.0, r * r];
        let tangential = [1.0 / r, 1.0 / r.powi(3), 1.0, 2.0 * r * r];
        [radial, tangential]
    });
    let matrix = Matrix4::from_fn(|i, j| rows[i / 2][i % 2][j]);
    let Some(c) = matrix.lu().solve(&Vector4::new(1.0, 1.0, 0.0, 0.0)) else {
        return f64::NAN;
    };
    // The mean over the sphere of radius r of |grad^3 u|^2; the quadratic part has none.
    let third = |r: f64| {
        720.0 * c[0] * c[0] * r.powi(-8) - 8400.0 * c[0] * c[1] * r.powi(-10)
            + 37800.0 * c[1] * c[1] * r.powi(-12)
    };
    ALLOWANCE * energy(size, wall, third) / (6.0 * PI * concentric_drag(lambda))
}

/// As [`drag`], for the torque of a sphere that turns: $u = A\, \omega \times r / r^3 + B\, \omega \times r$.
pub fn torque(size: f64, lambda: f64) -> f64 {
    let a = concentric_torque(lambda);
    let third = |r: f64| 1680.0 * a * a * r.powi(-10);
    ALLOWANCE * energy(size, 1.0 / lambda, third) / (8.0 * PI * a)
}

/// $\int \kappa^2 h^4 |\nabla^3 u|^2$ over `1 < r < wall`, with elements that grow as the generator lets them.
fn energy(size: f64, wall: f64, third: impl Fn(f64) -> f64) -> f64 {
    let growth = swimmer::model::fem::growth(size);
    // In the logarithm of r the integrand is smooth: the midpoint rule errs by (ln wall / 400)^2, below a thousandth.
    const POINTS: usize = 400;
    let step = wall.ln() / POINTS as f64;
    let shell = |k: usize| {
        let r = ((k as f64 + 0.5) * step).exp();
        let h = size + growth * (r - 1.0);
        h.powi(4) * third(r) * 4.0 * PI * r.powi(3) * step
    };
    INTERPOLATION * (0..POINTS).map(shell).sum::<f64>()
}

/// Error left by a method of second order or better, from the change between a mesh and one of half the size: a third.
pub fn from_halving(coarse: f64, fine: f64) -> f64 {
    (coarse - fine).abs() / 3.0
}

/// Error of the force on two unit spheres that approach each other, relative to the drag of one, `6 pi U`, from the elements
/// in their gap that are kept below `size` by the gap: what a mesh with half the surface size does not refine.
///
/// In a gap of width `H = gap + rho^2` the flow is $u_x = \tfrac{3 U x}{2 H} (1 - 4 z^2 / H^2)$, `u_y` alike, and
/// $u_z = -\tfrac{3 U}{H} (z - \tfrac{4 z^3}{3 H^2})$: $|\nabla^3 u|^2 = (24^2 + 6 \cdot 12^2) U^2 / H^6$ to leading order; elements are
/// a fixed part of `H`. The power is `2 U` times the force.
pub fn gap(gap: f64, size: f64) -> f64 {
    let part = GenerateParams::default().gap;
    let widest = size / part;
    if widest <= gap {
        return 0.0;
    }
    // Integral of (part H)^4 1440 / H^6 over H pi dH.
    let energy = INTERPOLATION * part.powi(4) * 1440.0 * PI * (widest / gap).ln();
    ALLOWANCE * energy / (2.0 * 6.0 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_energy_is_the_integral_over_the_fluid() {
        // Unbounded fluid, A = 3/4, B = 1/4: the integrals of r^-6, r^-8, r^-10 from 1 on.
        let [a, b] = [0.75, 0.25];
        let exact = 4.0 * PI * (720.0 * a * a / 5.0 - 8400.0 * a * b / 7.0 + 37800.0 * b * b / 9.0);
        let third = |r: f64| {
            720.0 * a * a * r.powi(-8) - 8400.0 * a * b * r.powi(-10)
                + 37800.0 * b * b * r.powi(-12)
        };
        // Elements far larger on the sphere than their growth: h = size everywhere that matters.
        let size = 1e3;
        let computed = energy(size, 50.0, third) / size.powi(4);
        assert!((computed / (INTERPOLATION * exact) - 1.0).abs() < 2e-3);
    }

    #[test]
    fn tolerances_fall_with_the_fourth_power_until_growth_matters() {
        assert!(drag(0.6, 0.5) / drag(0.3, 0.5) > 8.0);
        assert!(drag(0.4, 0.1) < 6e-3 && drag(0.4, 0.1) > 2e-3);
        assert!(torque(0.4, 0.1) < 1e-2);
        assert_eq!(gap(1.0, 0.4), 0.0);
        assert!(gap(0.1, 0.4) > gap(0.5, 0.4));
    }
}
