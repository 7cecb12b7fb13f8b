//! Exact signs of the orientation and in-sphere determinants, by Shewchuk's adaptive arithmetic.

use crate::Vec3;
use robust::Coord3D;

fn coord(p: &Vec3) -> Coord3D<f64> {
    Coord3D {
        x: p.x,
        y: p.y,
        z: p.z,
    }
}

/// A number with the sign of `det(b - a, c - a, d - a)`: positive for a positively oriented tet.
#[inline]
pub(super) fn orientation(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3) -> f64 {
    -robust::orient3d(coord(a), coord(b), coord(c), coord(d))
}

/// A number with the sign of the in-sphere predicate for the positively oriented tet `a b c d`.
///
/// Positive if `e` lies strictly inside the circumsphere of the tet, zero if `e` lies on it.
#[inline]
pub(super) fn in_sphere(a: &Vec3, b: &Vec3, c: &Vec3, d: &Vec3, e: &Vec3) -> f64 {
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
