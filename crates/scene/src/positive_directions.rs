//! The sign of functions of the direction.

use std::collections::VecDeque;
use std::f64::consts::PI;

use nalgebra::Vector3;

/// A direction with the value of the function.
#[derive(Clone, Copy)]
struct Corner {
    direction: Vector3<f64>,
    value: f64,
}

/// A part of the unit sphere between its corners: an arc of a great circle, or a triangle of them.
#[derive(Clone, Copy)]
enum Part {
    Arc([Corner; 2]),
    Triangle([Corner; 3]),
}

/// What is known of the sign of a function of the direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sign {
    /// Positive everywhere, also after the decrease.
    Within,
    /// Positive everywhere, but maybe not after the decrease.
    Here,
    /// Positive in all directions of a grid finer than a tenth of the shortest wave of modes, on
    /// which the bounds do not exclude others between them.
    Unproven,
    /// So small around this direction that no part of [`LEAST_RADIUS`] excludes a zero.
    Near(Vector3<f64>),
    /// Not positive in this direction.
    NotAt(Vector3<f64>),
}

impl Sign {
    /// The same with its direction in other axes.
    pub(crate) fn map(self, turn: impl Fn(Vector3<f64>) -> Vector3<f64>) -> Self {
        match self {
            Self::Near(at) => Self::Near(turn(at)),
            Self::NotAt(at) => Self::NotAt(turn(at)),
            other => other,
        }
    }
}

/// Largest angle between the centre of a part and its corners below which a part is not divided.
const LEAST_RADIUS: f64 = 1e-3;

/// Number of parts that are divided before the rest is not: 2728 make a grid of three degrees, or
/// finer.
const MAX_PARTS: usize = 5_000;

impl Part {
    /// Arcs of one meridian, or the octants of the sphere.
    fn all(is_meridian: bool, corner: &impl Fn(Vector3<f64>) -> Corner) -> VecDeque<Self> {
        let at = |k: u32| {
            let (x, z) = (0.25 * PI * f64::from(k)).sin_cos();
            corner(Vector3::new(x, 0.0, z))
        };
        if is_meridian {
            return (0..4).map(|k| Self::Arc([at(k), at(k + 1)])).collect();
        }
        let sign = |octant: u32, axis: u32| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        let unit = |octant: u32, axis: usize| sign(octant, axis as u32) * Vector3::ith(axis, 1.0);
        (0..8)
            .map(|octant| Self::Triangle([0, 1, 2].map(|axis| corner(unit(octant, axis)))))
            .collect()
    }

    fn corners(&self) -> &[Corner] {
        match self {
            Self::Arc(ends) => ends,
            Self::Triangle(corners) => corners,
        }
    }

    /// Largest angle between the centre and another point, which is that of a corner.
    fn radius(&self) -> f64 {
        let corners = self.corners().iter().map(|corner| corner.direction);
        let centre = corners.clone().sum::<Vector3<f64>>().normalize();
        let angle = |corner: Vector3<f64>| 2.0 * (0.5 * (corner - centre).norm()).min(1.0).asin();
        corners.map(angle).fold(0.0, f64::max)
    }

    fn divided(&self, corner: &impl Fn(Vector3<f64>) -> Corner) -> Vec<Self> {
        let middle = |a: &Corner, b: &Corner| corner((a.direction + b.direction).normalize());
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

/// The sign of a function of the direction on the unit sphere, or on one meridian of a function
/// that is symmetric about the third axis, also after it decreases by at most `decrease`.
///
/// `bend` is an upper bound `C` of its second derivatives along great circles. With the angle `γ`
/// from the centre of a part of the radius `ρ`, `f - C (1 - cos γ) / cos ρ` is concave along them,
/// so that it is smallest at a corner: `f` is at least its smallest value at the corners less
/// `C (1 / cos ρ - 1)`. Parts are divided, the largest first, until that exceeds the decrease.
/// Values that are not numbers are not positive.
pub(crate) fn sign(
    is_meridian: bool,
    f: &dyn Fn(&Vector3<f64>) -> f64,
    bend: f64,
    decrease: f64,
) -> Sign {
    let corner = |direction: Vector3<f64>| Corner {
        direction,
        value: f(&direction),
    };
    let mut parts = Part::all(is_meridian, &corner);
    // Zero once the decrease is too large.
    let mut allowed = decrease;
    let (mut near, mut divided) = (None, 0);
    while let Some(part) = parts.pop_front() {
        let lower = |a: Corner, b: &Corner| if a.value < b.value { a } else { *b };
        let corners = part.corners();
        let is_bad = |own: &&Corner| own.value.is_nan() || own.value <= 0.0;
        if let Some(bad) = corners.iter().find(is_bad) {
            return Sign::NotAt(bad.direction);
        }
        let least = corners.iter().fold(corners[0], lower);
        if least.value <= allowed {
            allowed = 0.0;
        }
        let radius = part.radius();
        let loss = bend * (1.0 / radius.cos() - 1.0);
        if least.value > loss + allowed {
            continue;
        }
        if radius < LEAST_RADIUS {
            if least.value <= loss {
                near.get_or_insert(least.direction);
            }
            allowed = 0.0;
            continue;
        }
        divided += 1;
        if divided > MAX_PARTS {
            // Smaller decreases help only where none needs fewer parts.
            return match decrease > 0.0 {
                true => match sign(is_meridian, f, bend, 0.0) {
                    Sign::Within => Sign::Here,
                    other => other,
                },
                false => Sign::Unproven,
            };
        }
        parts.extend(part.divided(&corner));
    }
    match near {
        Some(at) => Sign::Near(at),
        None if allowed == decrease => Sign::Within,
        None => Sign::Here,
    }
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
        // The largest second derivative of exp(-500 angle²) is that at its middle.
        let Sign::NotAt(found) = sign(false, &dip(0.11), 1e3 * 0.11, 0.0) else {
            panic!("not found");
        };
        assert!((found - deepest).norm() < 0.02, "{found}");
        assert_eq!(sign(false, &dip(0.09), 1e3 * 0.09, 0.005), Sign::Within);
        // The smallest value is 0.01.
        assert_eq!(sign(false, &dip(0.09), 1e3 * 0.09, 0.02), Sign::Here);
        let found = sign(false, &dip(0.099_999), 1e3 * 0.1, 0.0);
        assert!(matches!(found, Sign::Near(_)), "{found:?}");
    }

    #[test]
    fn a_meridian_is_divided_into_arcs() {
        let f = |n: &Vector3<f64>| 1.01 + (5.0 * n.x.atan2(n.z)).cos();
        assert_eq!(sign(true, &f, 25.0, 0.0), Sign::Within);
        assert_eq!(sign(true, &f, 25.0, 0.02), Sign::Here);
        let f = |n: &Vector3<f64>| 0.99 + (5.0 * n.x.atan2(n.z)).cos();
        let Sign::NotAt(found) = sign(true, &f, 25.0, 0.0) else {
            panic!("not found");
        };
        assert!(f(&found) <= 0.0);
        assert!(matches!(
            sign(true, &|_| f64::NAN, 0.0, 0.0),
            Sign::NotAt(_)
        ));
    }

    /// A bound that is too weak to exclude anything is no zero.
    #[test]
    fn what_is_not_excluded_is_no_zero() {
        assert_eq!(sign(false, &|_| 1.0, 1e9, 0.5), Sign::Unproven);
    }
}
