//! Radial functions of spheres that their modes deform.

use std::collections::BTreeMap;
use std::f64::consts::{PI, SQRT_2, TAU};
use std::sync::LazyLock;

use nalgebra::{Matrix3, Vector3};

use crate::harmonics::{Harmonic, Jet, MAX_MODE_DEGREE};
use crate::positive_directions::{Sign, sign};

/// Radial function `R (1 + Σ a Y / p)^p` of a sphere that its modes deform, over directions whose
/// third coordinate is along the axis of the modes and whose first one is along their meridian.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RadialProfile {
    /// `R`.
    pub radius: f64,
    /// `p`: one, or a third for modes that keep the volume.
    pub power: f64,
    /// The harmonics `Y` with their amplitudes `a`.
    pub terms: Vec<(Harmonic, f64)>,
}

/// Number of angles from the axis at which modes that are symmetric about it are examined; between
/// them a mode of the highest degree changes by less than a thousandth of its amplitude.
const ANGLES: usize = 1024;

/// Numbers of angles and azimuths for other modes, a tenth of the shortest wave apart.
const GRID: [usize; 2] = [60, 120];

/// Unit vectors all around, or along one meridian where all are the same.
fn directions(is_zonal: bool) -> impl Iterator<Item = Vector3<f64>> {
    let [angles, azimuths] = if is_zonal { [ANGLES, 1] } else { GRID };
    let angle = move |k: usize| (PI * k as f64 / angles as f64).sin_cos();
    let azimuth = move |k: usize| (TAU * k as f64 / azimuths as f64).sin_cos();
    (0..=angles).flat_map(move |i| {
        let (across, along) = angle(i);
        (0..azimuths).map(move |k| {
            let (y, x) = azimuth(k);
            Vector3::new(across * x, across * y, along)
        })
    })
}

impl RadialProfile {
    /// That of a sphere.
    pub(crate) fn sphere(radius: f64) -> Self {
        Self {
            radius,
            power: 1.0,
            terms: Vec::new(),
        }
    }

    /// Whether the surface is symmetric about the axis.
    pub(crate) fn is_zonal(&self) -> bool {
        self.terms.iter().all(|(harmonic, _)| harmonic.order == 0)
    }

    /// Amplitudes of the Legendre polynomials of the degrees from zero to [`MAX_MODE_DEGREE`].
    pub fn legendre_amplitudes(&self) -> [f64; MAX_MODE_DEGREE + 1] {
        let mut amplitudes = [0.0; MAX_MODE_DEGREE + 1];
        for (harmonic, amplitude) in self.terms.iter().filter(|(own, _)| own.order == 0) {
            if let Some(own) = amplitudes.get_mut(harmonic.degree) {
                *own += amplitude;
            }
        }
        amplitudes
    }

    /// `1 + Σ a Y / p` in a direction.
    fn base(&self, n: &Vector3<f64>) -> f64 {
        let terms = self.terms.iter().map(|(harmonic, a)| a * harmonic.at(n));
        1.0 + terms.sum::<f64>() / self.power
    }

    /// Distance of the surface from the centre in a direction, a unit vector.
    pub fn at(&self, n: &Vector3<f64>) -> f64 {
        self.radius * self.base(n).powf(self.power)
    }

    /// Derivative of [`RadialProfile::at`] with respect to the amplitude of a harmonic.
    pub fn rate(&self, harmonic: Harmonic, n: &Vector3<f64>) -> f64 {
        self.radius * self.base(n).powf(self.power - 1.0) * harmonic.at(n)
    }

    /// Value, gradient and second derivatives in space of a function that is [`RadialProfile::at`]
    /// on the sphere.
    pub(crate) fn jet(&self, n: &Vector3<f64>) -> Jet {
        let mut base: Jet = (1.0, Vector3::zeros(), Matrix3::zeros());
        for (harmonic, amplitude) in &self.terms {
            let (value, gradient, second) = harmonic.jet(n);
            let a = amplitude / self.power;
            base = (
                base.0 + a * value,
                base.1 + a * gradient,
                base.2 + a * second,
            );
        }
        let (b, gradient, second) = base;
        let p = self.power;
        let factor = self.radius * p * b.powf(p - 1.0);
        let curved = second + (p - 1.0) / b * gradient * gradient.transpose();
        (self.radius * b.powf(p), factor * gradient, factor * curved)
    }

    /// Distance of the surface from the centre at an angle with the axis, about which it is
    /// symmetric, and its first and second derivatives with respect to the angle, from its sine
    /// and cosine.
    pub(crate) fn along_meridian(&self, (sine, cosine): (f64, f64)) -> [f64; 3] {
        let (value, gradient, second) = self.jet(&Vector3::new(sine, 0.0, cosine));
        [
            value,
            -sine * gradient.z,
            sine * sine * second.m33 - cosine * gradient.z,
        ]
    }

    /// Bound of the size of `Σ a Y / p`: harmonics of one degree are at most the root of the sum
    /// of the squares of their amplitudes.
    fn largest_change(&self) -> f64 {
        bound(&self.terms, |_| 1.0) / self.power
    }

    /// Lower bound of `1 + Σ a Y / p` for finite amplitudes: the smallest sample, less what the
    /// harmonics may fall from there to a minimum between samples.
    ///
    /// At a distance `h` from a minimum that is at most `h²/2` times the second derivative.
    pub(crate) fn smallest_base(&self) -> f64 {
        let all = directions(self.is_zonal()).map(|n| self.base(&n));
        let least = all.fold(f64::INFINITY, f64::min);
        let distance = match self.is_zonal() {
            true => 0.5 * PI / ANGLES as f64,
            // half of the diagonal of a cell at the equator
            false => 0.5 * SQRT_2 * PI / GRID[0] as f64,
        };
        let fall = 0.5 * distance * distance * largest_second_derivative(&self.terms) / self.power;
        least - fall
    }

    /// Whether the centre is inside the surface, also where amplitudes differ from these by at most
    /// the changes: the sign of `1 + Σ a Y / p`.
    pub(crate) fn centre_inside(&self, changes: &[(Harmonic, f64)]) -> Sign {
        let change = bound(changes, |_| 1.0) / self.power;
        if self.largest_change() + change < 1.0 {
            return Sign::Within;
        }
        if !self.terms.iter().all(|(_, a)| a.is_finite()) {
            return Sign::NotAt(Vector3::z());
        }
        let bend = largest_second_derivative(&self.terms) / self.power;
        sign(self.is_zonal(), &|n| self.base(n), bend, change)
    }

    /// Upper bound of the distances of the surface from the centre, stretched along the axis by
    /// this factor; the largest one of modes that are symmetric about it.
    pub(crate) fn largest(&self, aspect: f64) -> f64 {
        if !self.is_zonal() {
            let base = 1.0 + self.largest_change();
            return self.radius * base.powf(self.power) * aspect.max(1.0);
        }
        let stretch = |z: f64| (1.0 + (aspect * aspect - 1.0) * z * z).sqrt();
        let distances = directions(true).map(|n| stretch(n.z) * self.at(&n));
        distances.fold(0.0, f64::max)
    }

    /// Integral of a function of the direction over the unit sphere, of no higher azimuthal order
    /// than three times that of the modes.
    pub(crate) fn integral(&self, f: impl Fn(&Vector3<f64>) -> f64) -> f64 {
        // Powers of the radius are polynomials of degree 3 * 12 of the direction, or linear ones
        // for p = 1/3: the rule along the axis is exact up to degree 39, that around it up to the
        // order 39.
        let azimuths = if self.is_zonal() { 1 } else { 40 };
        let mut sum = 0.0;
        for &(z, weight) in gauss_20() {
            let across = (1.0 - z * z).sqrt();
            for k in 0..azimuths {
                let (y, x) = (TAU * f64::from(k) / f64::from(azimuths)).sin_cos();
                sum += weight * f(&Vector3::new(across * x, across * y, z));
            }
        }
        TAU / f64::from(azimuths) * sum
    }

    /// Volume inside the surface.
    pub fn volume(&self) -> f64 {
        self.integral(|n| self.at(n).powi(3)) / 3.0
    }
}

/// Bound of the second derivatives of `Σ a Y` along great circles.
///
/// Among the harmonics of a degree `n` with the sum of squares 1 the largest is
/// `(L (3 L - 2)/8)^(1/2)` with `L = n (n + 1)`: a derivative of `P_n(cos γ)` at `γ = 0`.
pub(crate) fn largest_second_derivative(terms: &[(Harmonic, f64)]) -> f64 {
    second_derivatives(terms, |_| 1.0)
}

/// The same with a weight for each degree.
pub(crate) fn second_derivatives(terms: &[(Harmonic, f64)], weight: impl Fn(f64) -> f64) -> f64 {
    bound(terms, |n| {
        let l = n * (n + 1.0);
        weight(n) * (l * (3.0 * l - 2.0) / 8.0).max(0.0).sqrt()
    })
}

/// Sum over the degrees of a weight times the root of the sum of the squares of the amplitudes.
pub(crate) fn bound(terms: &[(Harmonic, f64)], weight: impl Fn(f64) -> f64) -> f64 {
    let mut squares = BTreeMap::new();
    for (harmonic, amplitude) in terms {
        *squares.entry(harmonic.degree).or_insert(0.0) += amplitude * amplitude;
    }
    let of_degree = |(degree, square): (&usize, &f64)| weight(*degree as f64) * square.sqrt();
    squares.iter().map(of_degree).sum()
}

/// The Gauss-Legendre rule of twenty points on [-1, 1].
fn gauss_20() -> &'static [(f64, f64)] {
    const POINTS: usize = 20;
    static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| (0..POINTS).map(point).collect());
    fn point(k: usize) -> (f64, f64) {
        let n = POINTS as f64;
        let mut x = ((k as f64 + 0.75) / (n + 0.5) * PI).cos();
        let polynomials = |x: f64| {
            let (mut before, mut last) = (1.0, x);
            for degree in 2..=POINTS {
                let d = degree as f64;
                let next = ((2.0 * d - 1.0) * x * last - (d - 1.0) * before) / d;
                (before, last) = (last, next);
            }
            (last, n * (before - x * last) / (1.0 - x * x))
        };
        for _ in 0..8 {
            let (value, slope) = polynomials(x);
            x -= value / slope;
        }
        let (_, slope) = polynomials(x);
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    }
    &RULE
}
