//! The largest distance of the points of a body from the origin, for balls around it.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use nalgebra::{Isometry3, Vector3};

use crate::shape::Shape;

/// Difference of the bounds on a distance, over the distance, at which the search ends.
const ACCURACY: f64 = 1e-4;

/// Largest number of directions that are tried: those of a body that is nearly a ball about the
/// origin are all alike.
const DIRECTIONS: usize = 4000;

/// Directions through a square of a face of the cube.
struct Cell {
    /// Distance of the farthest point in the middle direction, and the bound in all of them.
    support: f64,
    bound: f64,
    /// Axis of the face, with its sign.
    face: (usize, f64),
    /// Middle and half width of the square.
    middle: [f64; 2],
    half: f64,
}

impl Cell {
    fn new(
        face: (usize, f64),
        middle: [f64; 2],
        half: f64,
        support: impl Fn(&Vector3<f64>) -> f64,
    ) -> Self {
        let at = |u: f64, v: f64| {
            let mut at = Vector3::zeros();
            at[face.0] = face.1;
            at[(face.0 + 1) % 3] = middle[0] + u;
            at[(face.0 + 2) % 3] = middle[1] + v;
            at.normalize()
        };
        let n = at(0.0, 0.0);
        // Of a convex spherical polygon a corner is farthest.
        let cosines = CORNERS.map(|[u, v]| at(half * u, half * v).dot(&n));
        let cosine = cosines.into_iter().fold(1.0, f64::min);
        let support = support(&n);
        Self {
            support,
            bound: support.max(0.0) / cosine,
            face,
            middle,
            half,
        }
    }
}

/// The corners of a square, from its middle.
const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]];

impl Ord for Cell {
    fn cmp(&self, other: &Self) -> Ordering {
        self.bound.total_cmp(&other.bound)
    }
}

impl PartialOrd for Cell {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Eq for Cell {}

impl PartialEq for Cell {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

/// Upper bound of the distance of the points of a body from the origin.
///
/// A point `y` with a direction within the angle `δ` of `n` has `|y| <= h(n) / cos δ` with the
/// support function `h` of the body. Cells of directions are divided where this bound is largest,
/// until it is within 1e-4 of the largest `h`.
pub(crate) fn farthest_distance(shape: &Shape, pose: &Isometry3<f64>) -> f64 {
    let (centre, rotation) = (pose.translation.vector, &pose.rotation);
    let support = |n: &Vector3<f64>| centre.dot(n) + shape.support_distance(rotation, n);
    let faces = (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]);
    let cells = faces.map(|face| Cell::new(face, [0.0; 2], 1.0, support));
    let mut cells: BinaryHeap<Cell> = cells.collect();
    let largest = cells.iter().map(|cell| cell.support);
    let (mut largest, mut tried) = (largest.fold(0.0, f64::max), cells.len());
    while let Some(first) = cells.pop() {
        let is_close = first.bound <= largest * (1.0 + ACCURACY);
        if is_close || tried >= DIRECTIONS || first.bound.is_nan() {
            return first.bound;
        }
        for [u, v] in CORNERS {
            let half = 0.5 * first.half;
            let middle = [first.middle[0] + half * u, first.middle[1] + half * v];
            let cell = Cell::new(first.face, middle, half, support);
            largest = largest.max(cell.support);
            tried += 1;
            cells.push(cell);
        }
    }
    f64::NAN
}

#[cfg(test)]
mod tests {
    use nalgebra::{Translation3, UnitQuaternion};

    use super::*;
    use crate::shapes::{CapsuleShape, EllipsoidShape};

    /// Capsules: the farther end and the radius; bodies that are balls about the origin.
    #[test]
    fn distances_are_bounds_that_are_close() {
        let capsule = |axis: Vector3<f64>| -> Shape {
            let axis = axis.normalize();
            CapsuleShape {
                radius: 0.4,
                half_length: 3.0,
                axis,
            }
            .into()
        };
        for (axis, centre) in [
            (Vector3::x(), Vector3::new(0.5, 0.3, -0.2)),
            (Vector3::new(1.0, 2.0, -1.0), Vector3::new(0.0, 1.0, 1.0)),
            (Vector3::z(), Vector3::zeros()),
        ] {
            let unit = axis.normalize();
            let ends = [1.0, -1.0].map(|sign: f64| (centre + sign * 2.6 * unit).norm() + 0.4);
            let exact = ends[0].max(ends[1]);
            let pose =
                Isometry3::from_parts(Translation3::from(centre), UnitQuaternion::identity());
            let found = farthest_distance(&capsule(axis), &pose);
            assert!(
                (exact..exact * (1.0 + 2.0 * ACCURACY)).contains(&found),
                "{found} {exact}"
            );
        }
        let round = EllipsoidShape {
            semi_axes: Vector3::new(1.0, 1.0, 1.000_01),
            orientation: Vector3::zeros(),
        };
        let found = farthest_distance(&round.into(), &Isometry3::identity());
        assert!((1.0..1.01).contains(&found), "{found}");
    }
}
