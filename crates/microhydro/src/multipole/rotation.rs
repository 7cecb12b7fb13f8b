//! Rotation of real spherical harmonics.

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
            let next = next_degree(&degrees[0], &degrees[l - 2], l as i32);
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

fn next_degree(first: &DMatrix<f64>, last: &DMatrix<f64>, l: i32) -> DMatrix<f64> {
    let one = |i: i32, j: i32| first[((i + 1) as usize, (j + 1) as usize)];
    let low = |a: i32, b: i32| last[((a + l - 1) as usize, (b + l - 1) as usize)];
    let p = |i: i32, a: i32, b: i32| {
        if b == l {
            one(i, 1) * low(a, l - 1) - one(i, -1) * low(a, 1 - l)
        } else if b == -l {
            one(i, 1) * low(a, 1 - l) + one(i, -1) * low(a, l - 1)
        } else {
            one(i, 0) * low(a, b)
        }
    };
    let delta = |a: i32, b: i32| -> f64 { if a == b { 1.0 } else { 0.0 } };
    let size = (2 * l + 1) as usize;
    DMatrix::from_fn(size, size, |row, column| {
        let (m, n) = (row as i32 - l, column as i32 - l);
        let whole = if n.abs() == l {
            2 * l * (2 * l - 1)
        } else {
            (l + n) * (l - n)
        };
        let root = |x: i32| (f64::from(x) / f64::from(whole)).sqrt();
        let mut sum = 0.0;
        if m.abs() < l {
            sum += root((l + m) * (l - m)) * p(0, m, n);
        }
        let size = m.abs();
        if m == 0 {
            sum -= 0.5 * (2.0_f64).sqrt() * root((l - 1) * l) * (p(1, 1, n) + p(-1, -1, n));
        } else {
            let v = 0.5 * root((l + size - 1) * (l + size));
            let term = if m > 0 {
                p(1, m - 1, n) * (1.0 + delta(m, 1)).sqrt()
                    - if m == 1 { 0.0 } else { p(-1, 1 - m, n) }
            } else {
                p(-1, -m - 1, n) * (1.0 + delta(m, -1)).sqrt()
                    + if m == -1 { 0.0 } else { p(1, m + 1, n) }
            };
            sum += v * term;
            if size + 1 < l {
                let w = -0.5 * root((l - size - 1) * (l - size));
                let term = if m > 0 {
                    p(1, m + 1, n) + p(-1, -m - 1, n)
                } else {
                    p(1, m - 1, n) - p(-1, 1 - m, n)
                };
                sum += w * term;
            }
        }
        sum
    })
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
