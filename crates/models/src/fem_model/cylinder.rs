//! Infinite cylinders: the meshed part ends far from the bodies.
//!
//! The flow that bodies drive in a cylinder of radius `R` decays along it as `e^(-k z / R)`. The
//! slowest mode is that of a force across the axis, `k = 2.5678 + 1.1226 i` (Liron & Shahar 1978;
//! the roots of the no-slip determinant are 4.4663 for axisymmetric flow and 3.9145 for the second
//! azimuthal number). The flow reflected at an end travels the distance `d` to the end twice, so an
//! end causes a relative error of `e^(-2 k d / R)`.

use mesher::{Capsule, Sphere};
use nalgebra::Vector3;

/// Real part of the exponent `k` of the slowest mode.
const DECAY: f64 = 2.5678;

/// Distance from the bodies to the ends of a new mesh, in radii: a relative error of 1e-9.
const NEW_END_DISTANCE: f64 = 4.0;

/// Distance to an end below which a new mesh is generated, in radii: a relative error of 3e-5.
const MIN_END_DISTANCE: f64 = 2.0;

/// The part of a cylinder about the x axis that is meshed around the given bodies.
pub fn capsule_around(radius: f64, bodies: &[Sphere]) -> Capsule {
    let (first, last) = extent(bodies);
    Capsule {
        centre: Vector3::x() * (0.5 * (first + last)),
        radius,
        half_length: 0.5 * (last - first) + NEW_END_DISTANCE * radius,
    }
}

/// Distance from the bodies to the nearer end, in radii of the cylinder.
pub fn end_distance(capsule: &Capsule, bodies: &[Sphere]) -> f64 {
    let (first, last) = extent(bodies);
    let [left, right] = [-1.0, 1.0].map(|side| capsule.centre.x + side * capsule.half_length);
    (first - left).min(right - last) / capsule.radius
}

/// Whether an end at this distance is too close to the bodies.
pub fn is_too_close(end_distance: f64) -> bool {
    end_distance < MIN_END_DISTANCE
}

/// Relative error of velocities caused by an end at this distance.
pub fn relative_error(end_distance: f64) -> f64 {
    (-2.0 * DECAY * end_distance).exp()
}

/// Smallest and largest coordinate of the surfaces along the axis.
fn extent(bodies: &[Sphere]) -> (f64, f64) {
    let start = (f64::INFINITY, f64::NEG_INFINITY);
    let (first, last) = bodies.iter().fold(start, |(first, last), body| {
        let x = body.centre.x;
        (first.min(x - body.radius), last.max(x + body.radius))
    });
    // Without bodies, the capsule is centred at the origin.
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
    fn ends_are_far_from_the_bodies_until_the_bodies_approach_them() {
        let bodies = |x: f64| {
            [0.0, 5.0].map(|offset| Sphere {
                centre: Vector3::new(x + offset, 0.5, 0.0),
                radius: 1.0,
            })
        };
        let capsule = capsule_around(3.0, &bodies(1.0));
        assert_eq!((capsule.centre.x, capsule.half_length), (3.5, 15.5));
        let distance = |x: f64| end_distance(&capsule, &bodies(x));
        assert_eq!(distance(1.0), NEW_END_DISTANCE);
        assert!(!is_too_close(distance(6.9)) && is_too_close(distance(7.1)));
        // e^(-2 · 2.5678 · 4)
        assert!((relative_error(NEW_END_DISTANCE) / 1.2e-9 - 1.0).abs() < 0.01);
        assert_eq!(capsule_around(3.0, &[]).centre, Vector3::zeros());
    }
}
