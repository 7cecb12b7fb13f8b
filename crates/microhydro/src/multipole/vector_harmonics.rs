//! Vector spherical harmonics at points of the unit sphere, and sets of such points.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;

use super::modes::{FAMILIES, Family, Modes};

/// A point of the unit sphere, with its weight in a sum over all points.
pub(super) struct SpherePoint {
    pub normal: Vector3<f64>,
    pub weight: f64,
    /// Cosine and sine of the angle from the z axis.
    polar: [f64; 2],
    azimuth: f64,
}

/// Quadrature of degree `2n - 1`: `n` Gauss points along the meridian, `2n` around the axis.
pub(super) fn quadrature(n: usize) -> Vec<SpherePoint> {
    let around = 2 * n;
    let mut points = Vec::with_capacity(n * around);
    for k in 0..n {
        // Newton's method for the roots of the Legendre polynomial, from its asymptotic roots.
        let mut cos = ((k as f64 + 0.75) / (n as f64 + 0.5) * PI).cos();
        let slope = |cos: f64| {
            let [last, before] = [n, n - 1].map(|l| legendre(l, cos));
            n as f64 * (before - cos * last) / (1.0 - cos * cos)
        };
        for _ in 0..8 {
            cos -= legendre(n, cos) / slope(cos);
        }
        let sin = (1.0 - cos * cos).sqrt();
        let weight = 2.0 / (sin * slope(cos)).powi(2);
        for j in 0..around {
            let azimuth = TAU * j as f64 / around as f64;
            points.push(SpherePoint {
                normal: Vector3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos),
                weight: weight * TAU / around as f64,
                polar: [cos, sin],
                azimuth,
            });
        }
    }
    points
}

/// `n` points of equal weights on a spiral (Swinbank & Purser 2006).
///
/// Heights at equal distances and azimuths at multiples of the golden angle: no harmonic vanishes
/// at all points, as it may at those of a [`quadrature`].
pub(super) fn spiral(n: usize) -> Vec<SpherePoint> {
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let point = |k: usize| {
        let cos = 1.0 - (2 * k + 1) as f64 / n as f64;
        let sin = (1.0 - cos * cos).sqrt();
        let azimuth = golden_angle * k as f64;
        SpherePoint {
            normal: Vector3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos),
            weight: 2.0 * TAU / n as f64,
            polar: [cos, sin],
            azimuth,
        }
    };
    (0..n).map(point).collect()
}

/// Evaluates the harmonics `W_lm`, `X_lm`, `V_lm` of an expansion.
pub(super) struct VectorHarmonics {
    modes: Modes,
    /// Factors that make `Y_lm` orthonormal, for `m = 0 ..= l` of each degree `l >= 1`.
    norms: Vec<Vec<f64>>,
}

impl VectorHarmonics {
    /// The harmonics of an expansion.
    pub fn new(modes: Modes) -> Self {
        let norm = |l: usize, m: usize| {
            let ratio: f64 = (l - m + 1..=l + m).map(|k| k as f64).product();
            let both = if m == 0 { 1.0 } else { 2.0 };
            (both * (2 * l + 1) as f64 / (2.0 * TAU * ratio)).sqrt()
        };
        let of_degree = |l: usize| (0..=l).map(|m| norm(l, m)).collect();
        Self {
            modes,
            norms: (1..=modes.order).map(of_degree).collect(),
        }
    }

    /// Squared norm of a harmonic on the unit sphere.
    pub fn norm_squared(family: Family, l: usize) -> f64 {
        let degree = l as f64;
        match family {
            Family::Stokeslet => degree * (2.0 * degree + 1.0),
            Family::Rotlet => degree * (degree + 1.0),
            Family::Source => (degree + 1.0) * (2.0 * degree + 1.0),
        }
    }

    /// The harmonics at a point, in the order of the modes.
    pub fn at(&self, point: &SpherePoint) -> Vec<Vector3<f64>> {
        let scalar = self.scalar_at(point);
        let mut vectors = Vec::with_capacity(self.modes.len());
        for family in FAMILIES {
            for l in 1..=self.modes.max_degree(family) {
                let degree = l as f64;
                vectors.extend(scalar[l * l - 1..l * (l + 2)].iter().map(|(y, gradient)| {
                    match family {
                        Family::Stokeslet => gradient + degree * *y * point.normal,
                        Family::Rotlet => point.normal.cross(gradient),
                        Family::Source => gradient - (degree + 1.0) * *y * point.normal,
                    }
                }));
            }
        }
        vectors
    }

    /// Real orthonormal harmonics `Y_lm` in a direction, `m = -l ..= l` of each degree `l >= 1`.
    pub fn scalar(&self, direction: &Vector3<f64>) -> Vec<f64> {
        let top = self.modes.order;
        let mut harmonics = vec![0.0; top * (top + 2)];
        let across = direction.xy().norm();
        let (sin, cos) = across.atan2(direction.z).sin_cos();
        let azimuth = direction.y.atan2(direction.x);
        let turns = multiples(top, azimuth);
        each_legendre(top, [cos, sin], |l, m, [_, p]| {
            let (s, c) = turns[m];
            let value = self.norms[l - 1][m] * p;
            harmonics[l * l - 1 + l + m] = value * c;
            if m > 0 {
                harmonics[l * l - 1 + l - m] = value * s;
            }
        });
        harmonics
    }

    /// Real orthonormal harmonics `Y_lm` and their surface gradients: `m = -l ..= l` of each degree
    /// `l >= 1`; `m < 0` is the sine.
    fn scalar_at(&self, point: &SpherePoint) -> Vec<(f64, Vector3<f64>)> {
        let top = self.modes.order;
        let mut harmonics = vec![(0.0, Vector3::zeros()); top * (top + 2)];
        let [cos, sin] = point.polar;
        let (s, c) = point.azimuth.sin_cos();
        let theta = Vector3::new(cos * c, cos * s, -sin);
        let phi = Vector3::new(-s, c, 0.0);
        let turns = multiples(top, point.azimuth);
        each_legendre(top, point.polar, |l, m, [before, p]| {
            let (s, c) = turns[m];
            let by_theta = (l as f64 * cos * p - (l + m) as f64 * before) / sin;
            let norm = self.norms[l - 1][m];
            let mut put = |row: usize, value: f64, by_phi: f64| {
                let gradient = theta * (by_theta * value) + phi * (p * by_phi / sin);
                harmonics[l * l - 1 + row] = (norm * p * value, norm * gradient);
            };
            put(l + m, c, -(m as f64) * s);
            if m > 0 {
                put(l - m, s, m as f64 * c);
            }
        });
        harmonics
    }
}

/// Sines and cosines of the multiples `0 ..= top` of an angle.
fn multiples(top: usize, angle: f64) -> Vec<(f64, f64)> {
    (0..=top).map(|m| (m as f64 * angle).sin_cos()).collect()
}

/// Calls `visit` with `l`, `m` and the associated Legendre functions `P_(l-1)^m` and `P_l^m`,
/// without the sign `(-1)^m`, at an angle of this cosine and sine: for `1 <= l <= top` and
/// `0 <= m <= l`, by orders `m`.
fn each_legendre(top: usize, [cos, sin]: [f64; 2], mut visit: impl FnMut(usize, usize, [f64; 2])) {
    let mut start = 1.0;
    for m in 0..=top {
        if m > 0 {
            start *= (2 * m - 1) as f64 * sin;
        }
        let (mut before, mut p) = (0.0, start);
        for l in m..=top {
            if l > m {
                let next =
                    ((2 * l - 1) as f64 * cos * p - (l + m - 1) as f64 * before) / (l - m) as f64;
                (before, p) = (p, next);
            }
            if l > 0 {
                visit(l, m, [before, p]);
            }
        }
    }
}

/// Legendre polynomial `P_l`.
fn legendre(l: usize, cos: f64) -> f64 {
    let (mut before, mut last) = (0.0, 1.0);
    for k in 1..=l {
        let next = ((2 * k - 1) as f64 * cos * last - (k - 1) as f64 * before) / k as f64;
        (before, last) = (last, next);
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rounding of the sums over the points, whose terms grow with the square of the degree.
    #[test]
    fn vector_harmonics_are_orthogonal_with_their_norms() {
        for (order, n) in [(4, 8), (11, 12)] {
            let modes = Modes { order };
            let harmonics = VectorHarmonics::new(modes);
            let mut products = nalgebra::DMatrix::zeros(modes.len(), modes.len());
            for point in quadrature(n) {
                let values = harmonics.at(&point);
                let values = nalgebra::Matrix3xX::from_columns(&values);
                products += point.weight * values.transpose() * &values;
            }
            for (family, l) in modes.shells() {
                for row in modes.shell(family, l) {
                    products[(row, row)] -= VectorHarmonics::norm_squared(family, l);
                }
            }
            let bound = 1e-14 * (order * order * n) as f64;
            assert!(products.amax() < bound, "{order}: {:e}", products.amax());
        }
    }

    #[test]
    fn points_on_the_spiral_are_spread_evenly() {
        let mut moments = nalgebra::Matrix3::zeros();
        for point in spiral(500) {
            assert!((point.normal.norm() - 1.0).abs() < 1e-15);
            moments += point.weight * point.normal * point.normal.transpose();
        }
        // The error of a spiral of n points is of order 1 / n.
        let exact = nalgebra::Matrix3::identity() * (2.0 * TAU / 3.0);
        assert!((moments - exact).amax() < 2.0 * TAU / 500.0);
    }
}
