//! Exact signs of the orientation and in-sphere determinants: a filter, then Shewchuk's adaptive
//! arithmetic.

use crate::Vec3;
use robust::Coord3D;

fn coord(p: &Vec3) -> Coord3D<f64> {
    Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    }
}

/// Bound of the rounding error of [`orientation`], relative to the cube of the largest coordinate
/// of an edge.
///
/// Shewchuk (1997) bounds the error by `(7 + 56 u) u` times the permanent, `u = 2^-53`. Each of its
/// six products is at most the cube.
const ORIENTATION_ERROR: f64 = 6.0 * 7.01 * (0.5 * f64::EPSILON);

/// Bound of the rounding error of [`in_sphere`], relative to the fifth power of the largest
/// coordinate of a vector to the fifth point.
///
/// Shewchuk (1997) bounds the error by `(16 + 224 u) u` times the permanent: four minors of six
/// products, times the squared length, at most three squares.
const IN_SPHERE_ERROR: f64 = 4.0 * 6.0 * 3.0 * 16.01 * (0.5 * f64::EPSILON);

/// A number with the sign of `det(b - a, c - a, d - a)`: positive for a positively oriented tet.
#[inline]
pub(crate) fn orientation(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> f64 {
    let (u, v, w) = (b - a, c - a, d - a);
    let determinant = u.dot(&v.cross(&w));
    let largest = u.amax().max(v.amax()).max(w.amax());
    if determinant.abs() > ORIENTATION_ERROR * (largest * largest * largest) {
        return determinant;
    }
    -robust::orient3d(coord(a), coord(b), coord(c), coord(d))
}

/// A number with the sign of the in-sphere predicate for the positively oriented tet `a b c d`.
///
/// Positive if `e` lies strictly inside the circumsphere of the tet, zero if `e` lies on it.
#[inline]
pub(super) fn in_sphere(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3, e: &Vec3) -> f64 {
    let [p, q, r, s] = [a - e, b - e, c - e, d - e];
    // Two by two minors of the first two coordinates, and three by three minors without one point.
    let minor = |x: &Vec3, y: &Vec3| x.x * y.y - y.x * x.y;
    let (pq, qr, rs, sp) = (minor(&p, &q), minor(&q, &r), minor(&r, &s), minor(&s, &p));
    let (pr, qs) = (minor(&p, &r), minor(&q, &s));
    let pqr = p.z * qr - q.z * pr + r.z * pq;
    let qrs = q.z * rs - r.z * qs + s.z * qr;
    let rsp = r.z * sp + s.z * pr + p.z * rs;
    let spq = s.z * pq + p.z * qs + q.z * sp;
    let determinant = (r.norm_squared() * spq - s.norm_squared() * pqr)
        + (p.norm_squared() * qrs - q.norm_squared() * rsp);
    let largest = p.amax().max(q.amax()).max(r.amax()).max(s.amax());
    let squared = largest * largest;
    if determinant.abs() > IN_SPHERE_ERROR * (squared * squared * largest) {
        return determinant;
    }
    -robust::insphere(coord(a), coord(b), coord(c), coord(d), coord(e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_follow_the_conventions_of_a_positive_tet() {
        let [o, x, y, z] = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        assert!(orientation(&o, &x, &y, &z) > 0.0);
        assert!(orientation(&o, &y, &x, &z) < 0.0);
        assert_eq!(orientation(&o, &x, &y, &(x + y)), 0.0);
        let centre = Vec3::repeat(0.25);
        assert!(in_sphere(&o, &x, &y, &z, &centre) > 0.0);
        assert!(in_sphere(&o, &x, &y, &z, &Vec3::repeat(1.1)) < 0.0);
        assert_eq!(in_sphere(&o, &x, &y, &z, &Vec3::repeat(1.0)), 0.0);
    }
}
