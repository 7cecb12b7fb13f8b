//! Rotation of a body along its path, with full turns.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

/// Part of a rotation vector along an axis that its part across the axis may have, for the rotation
/// to be about this axis: six degrees.
const MAX_TILT: f64 = 0.1;

/// Angle across the axis that is rounding, where a body has turned by whole turns.
const MAX_ROUNDING: f64 = 1e-9;

/// Rotation of a body along its path, summed over short steps.
///
/// A rotation vector alone cannot tell it: after a full turn a body is where it was, and after a
/// full turn about an axis that wobbles it has rotated by a little about any axis.
///
/// ```
/// use nalgebra::{UnitQuaternion, Vector3};
/// let mut turning = swimmer::Turning::default();
/// let step = UnitQuaternion::from_scaled_axis(Vector3::z());
/// let mut attitude = UnitQuaternion::identity();
/// for _ in 0..4 {
///     turning.append(&step);
///     attitude = step * attitude;
/// }
/// assert_eq!(turning.angle, 4.0);
/// // The shortest rotation vector is 4 - 2π = -2.28 about the axis.
/// assert!((turning.rotation_vector(&attitude).z - 4.0).abs() < 1e-14);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Turning {
    /// Integral of the angular velocity `∫ ω dt`, in the axes of the laboratory and in radians.
    pub vector: Vector3<f64>,
    /// Integral of its magnitude `∫ |ω| dt`: the angle through which the body has turned.
    pub angle: f64,
}

impl Turning {
    /// Appends a rotation by less than half a turn, in the axes of the laboratory.
    pub fn append(&mut self, step: &UnitQuaternion<f64>) {
        let step = step.scaled_axis();
        self.vector += step;
        self.angle += step.norm();
    }

    /// The same rotation of a body that begins with the attitude `start`, from the identity.
    #[must_use]
    pub fn after(&self, start: &UnitQuaternion<f64>) -> Self {
        let mut turning = Self::default();
        turning.append(start);
        Self {
            vector: turning.vector + self.vector,
            angle: turning.angle + self.angle,
        }
    }

    /// The rotation vector of the attitude that the body has reached, from that with zero vector.
    ///
    /// If it has turned about one axis, the vector counts all full turns. If the axis has changed
    /// so much that the attitude is not a rotation about the direction of `∫ ω dt`, no number of
    /// turns describes the path, and the vector is the shortest; `angle` still has the whole path.
    pub fn rotation_vector(&self, attitude: &UnitQuaternion<f64>) -> Vector3<f64> {
        let shortest = attitude.scaled_axis();
        let Some(axis) = self.vector.try_normalize(0.0) else {
            return shortest;
        };
        let along = shortest.dot(&axis);
        let across = (shortest - along * axis).norm();
        let turns = TAU * ((self.vector.norm() - along) / TAU).round();
        if across <= MAX_TILT * along.abs() {
            // All vectors of the attitude have one direction.
            shortest + shortest.normalize() * (turns * along.signum())
        } else if across <= MAX_ROUNDING {
            shortest + turns * axis
        } else {
            shortest
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A body that begins after 5 rad about z, and turns on by 3 rad.
    #[test]
    fn bug_rotations_after_a_periodic_start_are_those_since_the_start() {
        let about_z = |angle: f64| UnitQuaternion::from_scaled_axis(angle * Vector3::z());
        let start = about_z(5.0);
        let mut turning = Turning::default();
        for _ in 0..6 {
            turning.append(&about_z(0.5));
        }
        let now = about_z(8.0);
        let rotation = turning.rotation_vector(&(now * start.inverse()));
        assert!((rotation.z - 3.0).abs() < 1e-14, "{rotation}");
        // Attitudes begin with the shortest vector, 5 - 2π, and go on from there.
        let attitude = turning.after(&start).rotation_vector(&now);
        assert!((attitude.z - (8.0 - TAU)).abs() < 1e-14, "{attitude}");
    }

    /// The turning along `attitude(t)` for `t` in [0, end], in so many steps.
    fn along(
        attitude: impl Fn(f64) -> UnitQuaternion<f64>,
        end: f64,
        steps: u32,
    ) -> (Turning, UnitQuaternion<f64>) {
        let mut turning = Turning::default();
        let at = |k: u32| attitude(end * f64::from(k) / f64::from(steps));
        for k in 0..steps {
            turning.append(&(at(k + 1) * at(k).inverse()));
        }
        (turning, at(steps))
    }

    #[test]
    fn rotation_vectors_count_turns_in_both_directions() {
        let axis = Vector3::new(1.0, -2.0, 2.0) / 3.0;
        for direction in [-1.0, 1.0] {
            for k in 1..=80 {
                let end = TAU * f64::from(k) / 20.0;
                let about = |t: f64| UnitQuaternion::from_scaled_axis(axis * t * direction);
                let (turning, attitude) = along(about, end, 4 * k);
                let vector = turning.rotation_vector(&attitude);
                assert!(
                    (vector - axis * end * direction).norm() < 1e-11,
                    "{k}: {vector}"
                );
                assert!((turning.angle - end).abs() < 1e-11);
            }
        }
    }

    /// Turns were counted from one vector to the next, about the axis of the small rotation that is
    /// left after a full turn: their number depended on the steps.
    #[test]
    fn bug_turns_about_an_axis_that_wobbles_depended_on_the_steps() {
        for wobble in [0.02, 0.3] {
            let attitude = |t: f64| {
                UnitQuaternion::from_scaled_axis(Vector3::x() * (wobble * (0.3 * t).sin()))
                    * UnitQuaternion::from_scaled_axis(Vector3::z() * t)
            };
            let found = [200, 800, 6400].map(|steps| {
                let (turning, attitude) = along(attitude, 64.7, steps);
                let vector = turning.rotation_vector(&attitude);
                // It is a vector of the attitude, whatever turns it counts.
                let reached = UnitQuaternion::from_scaled_axis(vector);
                assert!(reached.angle_to(&attitude) < 1e-12);
                (vector, turning.angle)
            });
            let (finest, angle) = found[2];
            for (vector, other) in found {
                assert!((vector - finest).norm() < 1e-9, "{vector} {finest}");
                // Steps of a third of a radian, whose chords are shorter than the arc by less than
                // a part in a hundred of the change of the axis, at most `wobble`.
                assert!((other - angle).abs() < 1e-2 * wobble * angle);
            }
            // `|ω|^2 = 1 + (0.3 ε cos 0.3 t)^2`, between the angle about z and with all of the
            // wobble.
            assert!(angle >= 64.7 && angle < 64.7 * (1.0_f64).hypot(0.3 * wobble));
        }
    }
}
