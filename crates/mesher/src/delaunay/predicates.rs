//! Circumcentres of tets, and exact signs of the orientation and in-sphere determinants: a filter,
//! then Shewchuk's adaptive arithmetic.

use mesh::Vec3;
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

/// Bound of the errors of underflow, which are some units of the smallest subnormal number,
/// 2^-1074.
///
/// Where a product of a subnormal and a large number has a larger error, the relative bounds above
/// are larger too.
const UNDERFLOW: f64 = f64::MIN_POSITIVE;

/// A number with the sign of `det(b - a, c - a, d - a)`: positive for a positively oriented tet.
#[inline]
pub(crate) fn orientation(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> f64 {
    let (u, v, w) = (b - a, c - a, d - a);
    let determinant = u.dot(&v.cross(&w));
    let largest = u.amax().max(v.amax()).max(w.amax());
    if determinant.abs() > ORIENTATION_ERROR * (largest * largest * largest) + UNDERFLOW {
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
    if determinant.abs() > IN_SPHERE_ERROR * (squared * squared * largest) + UNDERFLOW {
        return determinant;
    }
    -robust::insphere(coord(a), coord(b), coord(c), coord(d), coord(e))
}

/// Circumcentre and volume of a tet.
#[inline]
pub(crate) fn circumcentre(x: [Vec3; 4]) -> (Vec3, f64) {
    let [u, v, w] = [x[1] - x[0], x[2] - x[0], x[3] - x[0]];
    let (vw, wu, uv) = (v.cross(&w), w.cross(&u), u.cross(&v));
    let det = u.dot(&vw);
    let arm = (u.norm_squared() * vw + v.norm_squared() * wu + w.norm_squared() * uv) / (2.0 * det);
    (x[0] + arm, det / 6.0)
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

    /// The filter once trusted a determinant that had underflowed, and the walk to a point of a
    /// tiny scene did not end.
    #[test]
    fn underflow_is_not_trusted() {
        let tiny = |x: f64, y: f64, z: f64| 1e-108 * Vec3::new(x, y, z);
        let [a, b] = [tiny(0.0, 0.0, 0.0), tiny(1.0, 0.1, 0.3)];
        let [c, d] = [tiny(0.3, 1.0, 0.7), tiny(1.3, 1.1, 1.0)];
        let exact = -robust::orient3d(coord(&a), coord(&b), coord(&c), coord(&d));
        assert_eq!(orientation(&a, &b, &c, &d), exact);
    }

    #[test]
    fn filtered_signs_are_the_exact_ones_next_to_spheres_and_planes() {
        // Points of a sphere whose coordinates are rounded, and one moved by some units of
        // rounding.
        let at = |k: f64| {
            let t = Vec3::new((3.1 * k).sin(), (1.7 * k).cos(), (0.9 * k).sin());
            Vec3::new(0.3, -7.0, 2.0) + 0.01 * t.normalize()
        };
        for n in 0..2000 {
            let k = f64::from(n);
            let [a, b, c, d] = [at(k), at(k + 0.21), at(k + 0.47), at(k + 0.83)];
            let e = at(k + 0.63) + Vec3::repeat(f64::EPSILON * f64::from(n % 9 - 4));
            let exact = -robust::insphere(coord(&a), coord(&b), coord(&c), coord(&d), coord(&e));
            assert_eq!(sign(in_sphere(&a, &b, &c, &d, &e)), sign(exact));
            let f = a + 0.3 * (b - a) + 0.4 * (c - a);
            let exact = -robust::orient3d(coord(&a), coord(&b), coord(&c), coord(&f));
            assert_eq!(sign(orientation(&a, &b, &c, &f)), sign(exact));
        }
    }

    fn sign(x: f64) -> i32 {
        i32::from(x > 0.0) - i32::from(x < 0.0)
    }
}
