//! Real spherical harmonics with their derivatives.

use nalgebra::{Matrix3, Vector3};

/// Highest degree of a mode.
pub const MAX_MODE_DEGREE: usize = 12;

/// A real spherical harmonic with the normalisation of Schmidt.
///
/// With the angle `θ` from the third axis and the azimuth `φ` from the first one towards the
/// second, the associated Legendre functions `P_n^m(cos θ) = sin^m θ P_n^(m)(cos θ)` with the
/// `m`th derivative of the Legendre polynomial, and `c = √(2 (n - |m|)! / (n + |m|)!)`:
///
/// ```text
/// m = 0    P_n(cos θ)
/// m > 0    c P_n^m(cos θ) cos(m φ)
/// m < 0    c P_n^|m|(cos θ) sin(|m| φ)
/// ```
///
/// Values at two directions satisfy `Σ_m Y_nm(a) Y_nm(b) = P_n(a · b)`, so that the amplitudes
/// `Y_nm(k)` of one degree are a Legendre mode about the axis `k`, and no harmonic exceeds one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Harmonic {
    /// Degree `n`.
    pub degree: usize,
    /// Order `m` from `-n` to `n`; zero for a mode that is symmetric about the third axis.
    pub order: i32,
}

/// Value, gradient and second derivatives of a polynomial.
pub(crate) type Jet = (f64, Vector3<f64>, Matrix3<f64>);

/// The `m`th derivative of the Legendre polynomial of a degree.
fn legendre_derivative(degree: usize, m: usize, z: f64) -> f64 {
    if m > degree {
        return 0.0;
    }
    // (k - m) P_k^(m) = (2 k - 1) z P_(k-1)^(m) - (k + m - 1) P_(k-2)^(m), from (2 m - 1)!!
    let (mut before, mut last) = (0.0, (1..=m).map(|k| (2 * k - 1) as f64).product());
    for k in m + 1..=degree {
        let next = ((2 * k - 1) as f64 * z * last - (k + m - 1) as f64 * before) / (k - m) as f64;
        (before, last) = (last, next);
    }
    last
}

/// Real and imaginary part of `(x + i y)^m`.
fn power([x, y]: [f64; 2], m: usize) -> [f64; 2] {
    (0..m).fold([1.0, 0.0], |[re, im], _| [x * re - y * im, x * im + y * re])
}

impl Harmonic {
    fn m(self) -> usize {
        self.order.unsigned_abs() as usize
    }

    /// `c`.
    fn factor(self) -> f64 {
        let (n, m) = (self.degree, self.m());
        if m == 0 || m > n {
            // Above the degree there is no harmonic, and its polynomial is zero.
            return 1.0;
        }
        let ratio: f64 = (n - m + 1..=n + m).map(|k| k as f64).product();
        (2.0 / ratio).sqrt()
    }

    /// The part of `(x + i y)^k` that belongs to the order; zero for negative powers.
    fn part(self, w: [f64; 2], k: Option<usize>) -> [f64; 2] {
        let [re, im] = k.map_or([0.0; 2], |k| power(w, k));
        // The part itself, and its derivative with respect to y over that power's factor.
        if self.order < 0 { [im, re] } else { [re, -im] }
    }

    /// Value in a direction, a unit vector.
    pub fn at(self, n: &Vector3<f64>) -> f64 {
        let m = self.m();
        let [around, _] = self.part([n.x, n.y], Some(m));
        self.factor() * legendre_derivative(self.degree, m, n.z) * around
    }

    /// Value, gradient and second derivatives of the polynomial `c P_n^(m)(z) Re (x + i y)^m`, or
    /// with the imaginary part, which is the harmonic on the sphere.
    pub(crate) fn jet(self, n: &Vector3<f64>) -> Jet {
        let (m, w) = (self.m(), [n.x, n.y]);
        let along = [0, 1, 2].map(|k| self.factor() * legendre_derivative(self.degree, m + k, n.z));
        let [a, _] = self.part(w, Some(m));
        let first = self.part(w, m.checked_sub(1)).map(|d| m as f64 * d);
        let second = self.part(w, m.checked_sub(2));
        let second = second.map(|d| (m * m.saturating_sub(1)) as f64 * d);
        let gradient = Vector3::new(along[0] * first[0], along[0] * first[1], along[1] * a);
        let [xx, xy] = second.map(|d| along[0] * d);
        let [xz, yz] = first.map(|d| along[1] * d);
        #[rustfmt::skip]
        let curvature = Matrix3::new(
            xx, xy, xz,
            xy, -xx, yz,
            xz, yz, along[2] * a,
        );
        (along[0] * a, gradient, curvature)
    }

    /// Whether the harmonic changes its sign under reflection about the plane through the origin
    /// that is normal to an axis.
    pub(crate) fn is_odd(self, axis: usize) -> bool {
        let (of_degree, of_order) = (self.degree % 2 == 1, self.m() % 2 == 1);
        match axis {
            // φ to π - φ, φ to -φ, θ to π - θ
            0 => of_order != (self.order < 0),
            1 => self.order < 0,
            _ => of_degree != of_order,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> Vec<Vector3<f64>> {
        let all = [
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
            [0.6, 0.0, 0.8],
            [0.0, 1.0, 0.0],
            [0.3, -0.7, 0.2],
            [-2.0, 1.0, 0.5],
        ];
        all.map(|n| Vector3::from(n).normalize()).to_vec()
    }

    fn all(degree: usize) -> impl Iterator<Item = Harmonic> {
        let n = degree as i32;
        (-n..=n).map(move |order| Harmonic { degree, order })
    }

    #[test]
    fn harmonics_have_the_addition_theorem() {
        for degree in 0..=12 {
            for a in directions() {
                for b in directions() {
                    let sum: f64 = all(degree).map(|y| y.at(&a) * y.at(&b)).sum();
                    let exact = legendre_derivative(degree, 0, a.dot(&b));
                    assert!((sum - exact).abs() < 1e-13, "{degree}: {sum} {exact}");
                }
            }
        }
    }

    /// `Y_22 = √3/2 (x² - y²)`, `Y_2-1 = √3 y z`, `Y_1-1 = y`.
    #[test]
    fn harmonics_of_low_degree_are_as_written() {
        let n = Vector3::new(0.3, -0.7, 0.2).normalize();
        for (degree, order, exact) in [
            (2, 2, 0.75_f64.sqrt() * (n.x * n.x - n.y * n.y)),
            (2, -1, 3.0_f64.sqrt() * n.y * n.z),
            (1, -1, n.y),
            (1, 1, n.x),
        ] {
            let found = Harmonic { degree, order }.at(&n);
            assert!((found - exact).abs() < 1e-15, "{degree} {order}");
        }
    }

    /// Differences of the polynomial in space, and Laplace's operator on the sphere: `-n (n + 1)`.
    #[test]
    fn derivatives_are_those_of_the_values() {
        let h = 1e-5;
        for y in (1..=6).flat_map(all) {
            for n in directions() {
                let (value, gradient, second) = y.jet(&n);
                assert!((value - y.at(&n)).abs() < 1e-14);
                for k in 0..3 {
                    let step = h * Vector3::ith(k, 1.0);
                    let [up, down] = [n + step, n - step].map(|x| y.jet(&x));
                    let slope = (up.0 - down.0) / (2.0 * h);
                    assert!((slope - gradient[k]).abs() < 1e-6 * (1.0 + gradient.norm()));
                    let curve = (up.1 - down.1) / (2.0 * h) - second.column(k);
                    assert!(curve.norm() < 1e-6 * (1.0 + second.norm()), "{y:?}");
                }
                let along = second.trace() - n.dot(&(second * n)) - 2.0 * gradient.dot(&n);
                let l = (y.degree * (y.degree + 1)) as f64;
                assert!((along + l * value).abs() < 1e-12 * l * l, "{y:?}");
            }
        }
    }

    #[test]
    fn parities_are_those_of_the_values() {
        for y in (1..=5).flat_map(all) {
            for (n, axis) in directions()
                .into_iter()
                .flat_map(|n| [0, 1, 2].map(|k| (n, k)))
            {
                let mut mirrored = n;
                mirrored[axis] = -n[axis];
                let sign = if y.is_odd(axis) { -1.0 } else { 1.0 };
                assert!(
                    (y.at(&mirrored) - sign * y.at(&n)).abs() < 1e-14,
                    "{y:?} {axis}"
                );
            }
        }
    }
}
