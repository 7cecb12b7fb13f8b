//! Velocities of the surfaces of spheres in vector spherical harmonics: slip, background flow.

use std::f64::consts::{PI, TAU};

use faer::Mat;
use nalgebra::{DVector, Vector3};

use super::frame::Frame;
use super::memory;
use super::modes::{FAMILIES, Family};
use super::orders::Orders;
use super::rotation::AXIS_OF_M;
use super::scaled::drag_units;
use super::system::{MultiVector, System};
use super::truncation::{MAX_ORDER_OFF_AXIS, MAX_ORDER_ON_CONTAINER};
use crate::error::{check_entries, check_finite};
use crate::{HydroError, Medium, Spheres};

/// Velocity of the surface of a sphere relative to a rigid motion.
///
/// Arguments are the number of the sphere and the outward unit normal. The components are
/// polynomials in the normal: of degree two at most, or tangential and of degree three.
pub type SurfaceVelocity<'a> = dyn Fn(usize, &Vector3<f64>) -> Vector3<f64> + Sync + 'a;

/// Lowest order of expansions that contain every [`SurfaceVelocity`]: the families `W`, `X` and `V`
/// up to degrees 4, 3 and 2.
pub(super) const SURFACE_ORDER: usize = 4;

/// Residual of iterations with surface velocities, relative to the largest coefficient.
pub(super) const MAX_SURFACE_RESIDUAL: f64 = 1e-12;

/// Numbers of quadrature points along a meridian and around the axis.
///
/// They integrate polynomials up to degrees 15 and 15; the products of velocities and harmonics
/// have degrees up to 8.
const QUADRATURE_POINTS: [usize; 2] = [8, 16];

/// Orders for flows of moving surfaces: those of the resistance, of the spheres alone.
///
/// Every expansion has at least the order `lowest`; the orders of the resistance are limited.
///
/// # Errors
/// Spheres outside the medium; [`HydroError::TooLarge`].
pub(super) fn orders(
    spheres: &Spheres,
    medium: &Medium,
    of_resistance: &Orders,
    lowest: usize,
) -> Result<Orders, HydroError> {
    spheres.check_inside(medium)?;
    memory::check_spheres(spheres.len())?;
    let orders = (of_resistance.without_gaps())
        .limited(MAX_ORDER_OFF_AXIS, MAX_ORDER_ON_CONTAINER)
        .at_least(&Orders::all(spheres.len(), medium, lowest));
    memory::check_one_solution(&orders, matches!(medium, Medium::Wall { .. }))?;
    Ok(orders)
}

/// Coefficients of the velocities in scaled modes, one column per velocity.
///
/// The container is at rest.
pub(super) fn traces(
    system: &System,
    frame: &Frame,
    velocities: &[&SurfaceVelocity<'_>],
) -> MultiVector {
    let mut traces = system.zeros(velocities.len());
    let points = quadrature();
    for (column, velocity) in velocities.iter().enumerate() {
        for (sphere, trace) in traces.iter_mut().enumerate().take(system.spheres) {
            for point in &points {
                let normal = frame.to_axes.inverse() * point.normal;
                let value = frame.to_axes * velocity(sphere, &normal);
                add_projection(system, sphere, point, &value, column, trace);
            }
        }
    }
    traces
}

/// Largest coefficient.
pub(super) fn largest(coefficients: &MultiVector) -> f64 {
    coefficients.iter().map(Mat::norm_max).fold(0.0, f64::max)
}

/// Coefficients in scaled modes of the velocities of spheres that move, and of their surfaces.
///
/// `velocities` has six entries `(U, ω)` per sphere.
///
/// # Errors
/// [`HydroError::Length`], [`HydroError::NotFinite`] for the velocities and those of surfaces.
pub(super) fn of_moving_spheres(
    system: &System,
    frame: &Frame,
    velocities: &DVector<f64>,
    surface_velocity: Option<&SurfaceVelocity<'_>>,
) -> Result<MultiVector, HydroError> {
    let (expected, found) = (6 * system.spheres, velocities.len());
    check_entries("velocities of the spheres", expected, found)?;
    check_finite("a velocity of a sphere", velocities)?;
    let mut coefficients = match surface_velocity {
        Some(velocity) => traces(system, frame, &[velocity]),
        None => system.zeros(1),
    };
    if !coefficients.iter().all(Mat::is_all_finite) {
        return Err(HydroError::NotFinite {
            what: "the velocity of a surface",
        });
    }
    let spheres = system.expansions.iter().take(system.spheres);
    let radii: Vec<f64> = spheres.map(|sphere| sphere.radius).collect();
    let units = drag_units(&radii);
    for sphere in 0..system.spheres {
        for (k, row) in system.rigid_rows(sphere).into_iter().enumerate() {
            let first = 6 * sphere + 3 * (k / 3);
            let local = frame.to_axes * velocities.fixed_rows::<3>(first).into_owned();
            coefficients[sphere][(row, 0)] += units[6 * sphere + k] * local[AXIS_OF_M[k % 3]];
        }
    }
    Ok(coefficients)
}

/// Adds the share of one quadrature point to the coefficients of a velocity.
fn add_projection(
    system: &System,
    sphere: usize,
    point: &Point,
    value: &Vector3<f64>,
    column: usize,
    trace: &mut Mat<f64>,
) {
    let expansion = &system.expansions[sphere];
    for family in FAMILIES {
        for l in 1..=SURFACE_ORDER - family.shift() {
            let rows = expansion.modes.shell(family, l);
            let (degree, weight) = (l as f64, expansion.weight(family, l));
            let norm_squared = match family {
                Family::Stokeslet => degree * (2.0 * degree + 1.0),
                Family::Rotlet => degree * (degree + 1.0),
                Family::Source => (degree + 1.0) * (2.0 * degree + 1.0),
            };
            for (k, row) in rows.enumerate() {
                let (y, gradient) = point.harmonic(l, k as i32 - l as i32);
                let mode = match family {
                    Family::Stokeslet => gradient + degree * y * point.normal,
                    Family::Rotlet => point.normal.cross(&gradient),
                    Family::Source => gradient - (degree + 1.0) * y * point.normal,
                };
                trace[(row, column)] += point.weight * weight / norm_squared * mode.dot(value);
            }
        }
    }
}

/// A quadrature point on the unit sphere.
struct Point {
    normal: Vector3<f64>,
    weight: f64,
    /// Cosine and sine of the angle from the z axis.
    polar: [f64; 2],
    azimuth: f64,
}

impl Point {
    /// Real orthonormal harmonic `Y_lm` and its surface gradient; `m < 0` is the sine.
    fn harmonic(&self, l: usize, m: i32) -> (f64, Vector3<f64>) {
        let order = m.unsigned_abs() as usize;
        let [cos, sin] = self.polar;
        let (p, before) = (
            legendre(l, order, cos, sin),
            legendre(l - 1, order, cos, sin),
        );
        let by_theta = (l as f64 * cos * p - (l + order) as f64 * before) / sin;
        let ratio: f64 = (l - order + 1..=l + order).map(|k| k as f64).product();
        let both = if m == 0 { 1.0 } else { 2.0 };
        let norm = (both * (2 * l + 1) as f64 / (2.0 * TAU * ratio)).sqrt();
        let (s, c) = (order as f64 * self.azimuth).sin_cos();
        let (value, by_phi) = match m < 0 {
            true => (s, order as f64 * c),
            false => (c, -(order as f64) * s),
        };
        let (s, c) = self.azimuth.sin_cos();
        let theta = Vector3::new(cos * c, cos * s, -sin);
        let phi = Vector3::new(-s, c, 0.0);
        let gradient = theta * (by_theta * value) + phi * (p * by_phi / sin);
        (norm * p * value, norm * gradient)
    }
}

/// Associated Legendre function `P_l^m` without the sign `(-1)^m`; zero for `l < m`.
fn legendre(l: usize, m: usize, cos: f64, sin: f64) -> f64 {
    let start: f64 = (1..=m).map(|k| (2 * k - 1) as f64 * sin).product();
    let (mut before, mut last) = (0.0, if l < m { 0.0 } else { start });
    for k in m + 1..=l {
        let next = ((2 * k - 1) as f64 * cos * last - (k + m - 1) as f64 * before) / (k - m) as f64;
        (before, last) = (last, next);
    }
    last
}

/// Gauss points along the meridian, equal angles around the axis.
fn quadrature() -> Vec<Point> {
    let [n, around] = QUADRATURE_POINTS;
    let mut points = Vec::with_capacity(n * around);
    for k in 0..n {
        // Newton's method for the roots of the Legendre polynomial, from its asymptotic roots.
        let mut cos = ((k as f64 + 0.75) / (n as f64 + 0.5) * PI).cos();
        let slope = |cos: f64| {
            let [last, before] = [n, n - 1].map(|l| legendre(l, 0, cos, 0.0));
            n as f64 * (before - cos * last) / (1.0 - cos * cos)
        };
        for _ in 0..8 {
            cos -= legendre(n, 0, cos, 0.0) / slope(cos);
        }
        let sin = (1.0 - cos * cos).sqrt();
        let weight = 2.0 / (sin * slope(cos)).powi(2);
        for j in 0..around {
            let azimuth = TAU * j as f64 / around as f64;
            points.push(Point {
                normal: Vector3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos),
                weight: weight * TAU / around as f64,
                polar: [cos, sin],
                azimuth,
            });
        }
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_are_orthonormal_and_their_gradients_orthogonal() {
        let points = quadrature();
        let degrees = || (1..=4_usize).flat_map(|l| (-(l as i32)..=l as i32).map(move |m| (l, m)));
        for a in degrees() {
            for b in degrees() {
                let (mut product, mut of_gradients) = (0.0, 0.0);
                for point in &points {
                    let [(y, g), (z, h)] = [a, b].map(|(l, m)| point.harmonic(l, m));
                    product += point.weight * y * z;
                    of_gradients += point.weight * g.dot(&h);
                }
                let same = if a == b { 1.0 } else { 0.0 };
                assert!((product - same).abs() < 1e-13, "{a:?} {b:?}: {product}");
                let expected = same * (a.0 * (a.0 + 1)) as f64;
                assert!((of_gradients - expected).abs() < 1e-12, "{a:?} {b:?}");
            }
        }
    }
}
