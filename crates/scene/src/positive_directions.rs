//! Functions of the direction that are certainly positive.

use std::f64::consts::PI;

use nalgebra::Vector3;

/// A part of the unit sphere between its corners: an arc of a great circle, or a triangle of them.
#[derive(Clone, Copy)]
enum Part {
    Arc([Vector3<f64>; 2]),
    Triangle([Vector3<f64>; 3]),
}

/// Largest angle between the centre of a part and its corners below which a part is not divided.
const LEAST_RADIUS: f64 = 2e-3;

/// Number of parts that are examined before the rest counts as not positive: those of a function
/// that is small on a curve around the sphere.
const MAX_PARTS: usize = 8_000;

fn middle(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    (a + b).normalize()
}

impl Part {
    /// Arcs of one meridian, or the octants of the sphere.
    fn all(is_meridian: bool) -> Vec<Self> {
        let at = |k: u32| {
            let (x, z) = (0.25 * PI * f64::from(k)).sin_cos();
            Vector3::new(x, 0.0, z)
        };
        if is_meridian {
            return (0..4).map(|k| Self::Arc([at(k), at(k + 1)])).collect();
        }
        let sign = |octant: u32, axis: u32| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let unit = |octant: u32, axis: usize| sign(octant, axis as u32) * Vector3::ith(axis, 1.0);
        (0..8)
            .map(|octant| Self::Triangle([0, 1, 2].map(|axis| unit(octant, axis))))
            .collect()
    }

    fn corners(&self) -> &[Vector3<f64>] {
        match self {
            Self::Arc(ends) => ends,
            Self::Triangle(corners) => corners,
        }
    }

    /// The centre, and the largest angle between it and another point, which is that of a corner.
    fn ball(&self) -> (Vector3<f64>, f64) {
        let centre = self.corners().iter().sum::<Vector3<f64>>().normalize();
        let angle = |corner: &Vector3<f64>| 2.0 * (0.5 * (corner - centre).norm()).min(1.0).asin();
        let angles = self.corners().iter().map(angle);
        (centre, angles.fold(0.0, f64::max))
    }

    fn divided(&self) -> Vec<Self> {
        match self {
            Self::Arc([a, b]) => {
                let m = middle(a, b);
                vec![Self::Arc([*a, m]), Self::Arc([m, *b])]
            }
            Self::Triangle([a, b, c]) => {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                let parts = [[*a, ab, ca], [ab, *b, bc], [ca, bc, *c], [ab, bc, ca]];
                parts.map(Self::Triangle).to_vec()
            }
        }
    }
}

/// A direction in which a function of the direction may be no longer positive; none if the function
/// certainly is positive everywhere, or on one meridian of a function that is symmetric about the
/// third axis.
///
/// `loss` is an upper bound of the decrease over an angle, and of what else is to be allowed for.
/// Parts of the sphere are divided until the function at their centres exceeds it. Values that are
/// not numbers are not positive.
pub(crate) fn not_positive(
    is_meridian: bool,
    f: impl Fn(&Vector3<f64>) -> f64,
    loss: impl Fn(f64) -> f64,
) -> Option<Vector3<f64>> {
    let mut parts = Part::all(is_meridian);
    let mut examined = 0;
    while let Some(part) = parts.pop() {
        let (centre, radius) = part.ball();
        let value = f(&centre);
        if value > loss(radius) {
            continue;
        }
        examined += 1;
        let is_certain = value > loss(0.0);
        if !is_certain || radius < LEAST_RADIUS || examined > MAX_PARTS {
            return Some(centre);
        }
        parts.extend(part.divided());
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function that dips below zero around one direction, which no grid of a few degrees sees.
    #[test]
    fn narrow_dips_are_found_and_others_excluded() {
        let deepest = Vector3::new(0.3, -0.5, 0.8).normalize();
        let dip = |depth: f64| {
            move |n: &Vector3<f64>| 0.1 - depth * (-1e3 * (1.0 - n.dot(&deepest))).exp()
        };
        // The largest slope of exp(-500 angle²) is that of its inflection, (1000 / e)^(1/2).
        let slope = |depth: f64| move |angle: f64| depth * (1e3_f64 / 1.0_f64.exp()).sqrt() * angle;
        let found = not_positive(false, dip(0.11), slope(0.11)).unwrap();
        assert!((found - deepest).norm() < 0.02, "{found}");
        assert!(not_positive(false, dip(0.09), slope(0.09)).is_none());
        // An allowance beside the angle is part of the loss.
        let allowed = |angle: f64| 0.02 + slope(0.09)(angle);
        assert!(not_positive(false, dip(0.09), allowed).is_some());
    }

    #[test]
    fn a_meridian_is_divided_into_arcs() {
        let f = |n: &Vector3<f64>| 1.01 + (5.0 * n.x.atan2(n.z)).cos();
        assert!(not_positive(true, f, |angle| 5.0 * angle).is_none());
        let f = |n: &Vector3<f64>| 0.99 + (5.0 * n.x.atan2(n.z)).cos();
        let found = not_positive(true, f, |angle| 5.0 * angle).unwrap();
        assert!(f(&found) <= 0.1);
        assert!(not_positive(true, |_| f64::NAN, |_| 0.0).is_some());
    }
}
