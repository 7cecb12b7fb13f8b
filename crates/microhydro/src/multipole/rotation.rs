//! Rotation of real spherical harmonics.

use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

use faer::MatRef;
use nalgebra::{DMatrix, Matrix3, UnitQuaternion, Vector3};

/// Index of the Cartesian axis (x, y, z) that belongs to `m = -1, 0, 1` in degree 1.
pub(super) const AXIS_OF_M: [usize; 3] = [1, 2, 0];

/// Rotation that takes `offset` to the z axis.
pub(crate) fn rotation_to_z(offset: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(offset, &Vector3::z()).unwrap_or_else(|| {
        // `offset` is opposite to z, or zero, for which any rotation is correct
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
    })
}

/// Matrices that rotate the coefficients of real spherical harmonics, one per degree.
///
/// A function `f = sum_m c_m Y_lm` rotated by `Q` has the coefficients `D^l(Q) c`. Computed by
/// recursion over the degree (Ivanic & Ruedenberg 1996, with the corrections of 1998). The matrices
/// are orthogonal, and `D(P Q) = D(P) D(Q)`. Cost: `O(top^3)` entries, a few operations each.
#[derive(Clone, Debug)]
pub(crate) struct Rotation {
    degrees: Vec<DMatrix<f64>>,
}

impl Rotation {
    /// Matrices of degrees `1 ..= top` for a rotation `Q`.
    pub fn new(rotation: &UnitQuaternion<f64>, top: usize) -> Self {
        let q: Matrix3<f64> = *rotation.to_rotation_matrix().matrix();
        let first = DMatrix::from_fn(3, 3, |i, j| q[(AXIS_OF_M[i], AXIS_OF_M[j])]);
        let mut degrees = vec![first];
        for l in 2..=top {
            let next = next_degree(&degrees[0], &degrees[l - 2], l);
            degrees.push(next);
        }
        degrees.truncate(top);
        Self { degrees }
    }

    /// Matrix of degree `l`; rows and columns are `m = -l ..= l`.
    pub fn degree(&self, l: usize) -> &DMatrix<f64> {
        &self.degrees[l - 1]
    }

    /// [`Rotation::degree`] as a view for faer.
    pub fn matrix(&self, l: usize) -> MatRef<'_, f64> {
        let degree = self.degree(l);
        MatRef::from_column_major_slice(degree.as_slice(), degree.nrows(), degree.ncols())
    }
}

/// The matrix of degree `l` from those of the degrees 1 and `l - 1`, column by column.
///
/// The weights of an entry are products of one number of its row and one of its column.
fn next_degree(first: &DMatrix<f64>, last: &DMatrix<f64>, l: usize) -> DMatrix<f64> {
    let top = l as i32;
    let root = |x: i32| f64::from(x).sqrt();
    let weights: Vec<[f64; 3]> = (0..=top)
        .map(|m| {
            let v = if m == 0 { -FRAC_1_SQRT_2 } else { 0.5 };
            [
                root((top + m) * (top - m)),
                v * root((top + m - 1) * (top + m)),
                -0.5 * root((top - m - 1).max(0) * (top - m)),
            ]
        })
        .collect();
    // products of rows of the first degree and a column of the last one, with two zeros around it
    let mut products = [(); 3].map(|()| vec![0.0; 2 * l + 3]);
    let mut next = DMatrix::zeros(2 * l + 1, 2 * l + 1);
    for n in -top..=top {
        let is_outer = n.abs() == top;
        let low = |n: i32| last.column((n + top - 1) as usize);
        for (i, products) in products.iter_mut().enumerate() {
            let inner = &mut products[2..2 * l + 1];
            if is_outer {
                let [same, other] = [2, 0].map(|j| first[(i, j)]);
                let other = if n > 0 { -other } else { other };
                let (of_same, of_other) = (low(n - n.signum()), low(n.signum() - n));
                for (product, (a, b)) in inner.iter_mut().zip(of_same.iter().zip(&of_other)) {
                    *product = same * a + other * b;
                }
            } else {
                for (product, a) in inner.iter_mut().zip(&low(n)) {
                    *product = first[(i, 1)] * a;
                }
            }
        }
        let p = |i: usize, m: i32| products[i][(m + top + 1) as usize];
        let scale = 1.0
            / match is_outer {
                true => root(2 * top * (2 * top - 1)),
                false => root((top + n) * (top - n)),
            };
        for (m, [u, v, w]) in (0..).zip(&weights) {
            let place = |m: i32| ((m + top) as usize, (n + top) as usize);
            if m == 0 {
                next[place(0)] = scale * (u * p(1, 0) + v * (p(2, 1) + p(0, -1)));
                continue;
            }
            // the azimuthal number zero has no sine
            let [cosine, sine] = if m == 1 { [SQRT_2, 0.0] } else { [1.0, 1.0] };
            next[place(m)] = scale
                * (u * p(1, m)
                    + v * (cosine * p(2, m - 1) - sine * p(0, 1 - m))
                    + w * (p(2, m + 1) + p(0, -m - 1)));
            next[place(-m)] = scale
                * (u * p(1, -m)
                    + v * (sine * p(2, 1 - m) + cosine * p(0, m - 1))
                    + w * (p(2, -m - 1) - p(0, m + 1)));
        }
    }
    next
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_are_orthogonal_and_follow_each_other() {
        let a = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7));
        let b = UnitQuaternion::from_scaled_axis(Vector3::new(-2.0, 0.4, 0.9));
        let (ra, rb, rab) = (
            Rotation::new(&a, 40),
            Rotation::new(&b, 40),
            Rotation::new(&(a * b), 40),
        );
        for l in [1, 2, 3, 7, 40] {
            // each step of the recursion adds a rounding error
            let rounding = 1e-14 * l as f64;
            let identity = DMatrix::identity(2 * l + 1, 2 * l + 1);
            assert!((ra.degree(l).tr_mul(ra.degree(l)) - identity).amax() < rounding);
            assert!((ra.degree(l) * rb.degree(l) - rab.degree(l)).amax() < rounding);
        }
    }

    #[test]
    fn degree_two_turns_its_polynomials() {
        // Y_2 in the order xy, yz, (2z^2 - x^2 - y^2)/sqrt 12, zx, (x^2 - y^2)/2, all of one norm
        let y2 = |v: Vector3<f64>| {
            nalgebra::DVector::from_column_slice(&[
                v.x * v.y,
                v.y * v.z,
                (2.0 * v.z * v.z - v.x * v.x - v.y * v.y) / 12.0_f64.sqrt(),
                v.z * v.x,
                (v.x * v.x - v.y * v.y) / 2.0,
            ])
        };
        let q = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7));
        let d = Rotation::new(&q, 2).degree(2).clone();
        let v = Vector3::new(0.2, 0.5, -0.8);
        // the values of harmonics rotate as coefficients do, because D is orthogonal
        assert!((d * y2(v) - y2(q * v)).amax() < 1e-14);
    }
}
