//! The part of Ewald's sums over images: flows that decay within a few lengths of the splitting.

use std::f64::consts::PI;

use nalgebra::{Matrix3, Vector3, Vector6};

use super::source::{Source, six_of};

/// `D g, .., D⁴ g` with `D = (1/r) d/dr`.
type Chain = [f64; 4];

/// The part of `f` that is summed over images, `h = ∇² f` and `q = ∇² h` at a distance.
struct Radial {
    squared: f64,
    f: Chain,
    h: Chain,
    q: Chain,
}

/// Velocity and angular velocity of a sphere of the radius `a` at `r` from an image of a source of
/// the radius `b`.
///
/// With `g = f + (a² + b²) h/6 + a² b² q/36` a force has `U = G F/(8π)`, `G = I ∇²g - ∇∇g`; a
/// torque half the curl of it. With the dipole `L`: `U = ∇²G L/(8π)`; with the stresslet `S` and
/// `β = D³g`, `α = 3 D²g + r² β`: `U = (α S r - β (r·S r) r)/(8π)`. Angular velocities are half the
/// curls, of a sphere without a size.
pub(super) fn velocity(
    splitting: f64,
    r: &Vector3<f64>,
    [a, b]: [f64; 2],
    source: &Source,
) -> Vector6<f64> {
    let radial = Radial::new(splitting, r.norm());
    let squared = radial.squared;
    let (force, torque) = (&source.force, &source.torque);
    // (I ∇²g - ∇∇g) v for the first two of a chain.
    let solenoidal = |first: f64, second: f64, v: &Vector3<f64>| {
        v * (2.0 * first + squared * second) - r * (second * r.dot(v))
    };
    let both = radial.finite(a, b);
    let coupling = |radius: f64| 0.5 * (radial.h[0] + radius * radius / 6.0 * radial.q[0]);
    let mut velocity = solenoidal(both[0], both[1], force) + r.cross(torque) * coupling(a);
    let mut rotation =
        r.cross(force) * coupling(b) - solenoidal(radial.h[0], radial.h[1], torque) * 0.25;
    if let Some((dipole, stresslet)) = &source.slip {
        let size = a * a / 6.0;
        let [first, second] = [0, 1].map(|k| radial.h[k] + size * radial.q[k]);
        velocity += solenoidal(first, second, dipole);
        rotation += r.cross(dipole) * (0.5 * radial.q[0]);
        let product = stresslet * r;
        let [_, second, third, _] = both;
        velocity += product * (3.0 * second + squared * third) - r * (third * r.dot(&product));
        let [_, _, third, fourth] = radial.finite(0.0, b);
        rotation += r.cross(&product) * (0.5 * (7.0 * third + squared * fourth));
    }
    six_of(velocity, rotation) / (8.0 * PI)
}

/// Velocity at `r` from an image of a point force, as a matrix: `(I ∇²f - ∇∇f)/(8π)`.
///
/// With `B_0` and `γ` of [`Radial`]: `(B_0 - γ) I + (B_0 + γ) r r/r²`.
pub(super) fn point(xi: f64, r: &Vector3<f64>) -> Matrix3<f64> {
    let squared = r.norm_squared();
    let distance = squared.sqrt();
    let decaying = libm::erfc(xi * distance) / distance;
    let gauss = 2.0 * xi / PI.sqrt() * (-xi * xi * squared).exp();
    let along = r * r.transpose() * ((decaying + gauss) / squared);
    (Matrix3::from_diagonal_element(decaying - gauss) + along) / (8.0 * PI)
}

/// Minus the velocity and angular velocity that the waves give a sphere by its own source in
/// unbounded fluid.
///
/// With `f - r = -(ξ r² - ξ³ r⁴/6 + ξ⁵ r⁶/30 - ..)/√π` up to a constant, `G = 4 c I` for the
/// coefficient `c` of `r²`.
pub(super) fn own(splitting: f64, radius: f64, source: &Source) -> Vector6<f64> {
    // Coefficients of r² in f - r, in its Laplacian, and in the Laplacian of that.
    let powers = [-1.0, 10.0 / 3.0, -28.0];
    let mut power = splitting / PI.sqrt();
    let [of_f, of_h, of_q] = powers.map(|factor| {
        let coefficient = factor * power;
        power *= splitting * splitting;
        coefficient
    });
    let square = radius * radius;
    let of_force = 4.0 * (of_f + square / 3.0 * of_h + square * square / 36.0 * of_q);
    let mut velocity = source.force * of_force;
    if let Some((dipole, _)) = &source.slip {
        velocity += dipole * (4.0 * (of_h + square / 6.0 * of_q));
    }
    six_of(velocity, source.torque * -of_h) / (8.0 * PI)
}

impl Radial {
    /// The part that is summed over images.
    ///
    /// With `B_0 = erfc(ξ r)/r`, `γ = 2ξ exp(-ξ² r²)/√π` and
    /// `B_n = ((2n - 1) B_(n-1) + (2ξ²)^(n-1) γ)/r²`, `D B_n = -B_(n+1)`: `D f = B_0`,
    /// `h = 2 B_0 - γ`, `q = (10 ξ² - 4 ξ⁴ r²) γ`.
    fn new(xi: f64, r: f64) -> Self {
        let squared = r * r;
        let slope = -2.0 * xi * xi;
        let (constant, linear) = (10.0 * xi * xi, -4.0 * xi.powi(4));
        let start = libm::erfc(xi * r) / r;
        let mut radial = Self {
            squared,
            f: [start, 0.0, 0.0, 0.0],
            h: [0.0; 4],
            q: [0.0; 4],
        };
        // B_n, (2ξ²)^n γ and the signs of both.
        let (mut decaying, mut gauss, mut sign) = (
            start,
            -slope / (xi * PI.sqrt()) * (-xi * xi * squared).exp(),
            1.0,
        );
        for n in 0..4 {
            let odd = f64::from(2 * n + 1);
            decaying = (odd * decaying + gauss) / squared;
            sign = -sign;
            let before = -sign * gauss;
            gauss *= -slope;
            let n = n as usize;
            if n < 3 {
                radial.f[n + 1] = sign * decaying;
            }
            radial.h[n] = 2.0 * sign * decaying - sign * gauss;
            let first = slope * (constant + linear * squared);
            radial.q[n] = before * (first + (odd + 1.0) * linear);
        }
        radial
    }

    /// The function of finite spheres of the radii `a` and `b`, `f + (a² + b²) h/6 + a² b² q/36`.
    fn finite(&self, a: f64, b: f64) -> Chain {
        let (c, d) = ((a * a + b * b) / 6.0, a * a * b * b / 36.0);
        [0, 1, 2, 3].map(|k| self.f[k] + c * self.h[k] + d * self.q[k])
    }
}
