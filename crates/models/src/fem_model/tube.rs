//! An infinite cylinder by elements: a piece of it, closed far from the bodies.
//!
//! FlowField that bodies drive in a cylinder decays along it as $e^{-k z / R}$. The slowest mode is that of a force across the axis,
//! $k = 2.5678 + 1.1226 i$ (Liron & Shahar 1978; the roots of the no-slip determinant, 4.4663 for axisymmetric flow, 3.9145 for the second
//! azimuthal number). What an end sends back has gone there and back, so it errs by $e^{-2 k d / R}$ at the distance `d`.

use mesh::{Capsule, Sphere};
use nalgebra::Vector3;

/// Real part of the slowest mode's exponent.
const DECAY: f64 = 2.5678;

/// Distance from the bodies to the ends, over the radius, in a new mesh: 1e-9 comes back.
const ENDS: f64 = 4.0;

/// Distance below which the ends are put farther away by a new mesh: 3e-5 comes back.
const NEAREST_END: f64 = 2.0;

/// The piece of a cylinder of this radius about the x axis that holds some bodies.
pub fn around(radius: f64, bodies: &[Sphere]) -> Capsule {
    let (first, last) = extent(bodies);
    Capsule {
        centre: Vector3::x() * (0.5 * (first + last)),
        radius,
        half_length: 0.5 * (last - first) + ENDS * radius,
    }
}

/// Distance from the bodies to the nearest end, over the radius.
pub fn to_end(capsule: &Capsule, bodies: &[Sphere]) -> f64 {
    let (first, last) = extent(bodies);
    let [left, right] = [-1.0, 1.0].map(|side| capsule.centre.x + side * capsule.half_length);
    (first - left).min(right - last) / capsule.radius
}

/// Whether an end has come so near that it is felt.
pub fn is_near(to_end: f64) -> bool {
    to_end < NEAREST_END
}

/// What is left of a relative error at a distance from the nearest end.
pub fn relative_error(to_end: f64) -> f64 {
    (-2.0 * DECAY * to_end).exp()
}

/// Along the axis, from the first to the last surface.
fn extent(bodies: &[Sphere]) -> (f64, f64) {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    let (first, last) = bodies.iter().fold(start, |(first, last), body| {
        let at = body.centre.x;
        (first.min(at - body.radius), last.max(at + body.radius))
    });
    // Without bodies the piece is about the origin.
    if first <= last {
        (first, last)
    } else {
        (0.0, 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_are_far_from_the_bodies_until_these_swim_there() {
        let bodies = |x: f64| {
            [0.0, 5.0].map(|at| Sphere {
                centre: Vector3::new(x + at, 0.5, 0.0),
                radius: 1.0,
            })
        };
        let tube = around(3.0, &bodies(1.0));
        assert_eq!((tube.centre.x, tube.half_length), (3.5, 15.5));
        assert_eq!(to_end(&tube, &bodies(1.0)), ENDS);
        assert!(!is_near(to_end(&tube, &bodies(6.9))) && is_near(to_end(&tube, &bodies(7.1))));
        // e^{-2 * 2.5678 * 4}
        assert!((relative_error(ENDS) / 1.2e-9 - 1.0).abs() < 0.01);
        assert_eq!(around(3.0, &[]).centre, Vector3::zeros());
    }
}
