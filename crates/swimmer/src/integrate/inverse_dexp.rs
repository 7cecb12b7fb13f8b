//! The differential of the exponential map of rotations.

use nalgebra::Vector3;
use rigid::{Articulation, StateVelocity, Twist};

/// The rate of the rotation vector `sigma` when `exp(sigma) Q` rotates with angular velocity
/// `omega`.
///
/// ```text
/// dexp^-1_sigma(omega) = omega - sigma x omega / 2 + g(theta) sigma x (sigma x omega)
/// g(theta) = (1 - theta/2 cot(theta/2)) / theta^2,   theta = |sigma| < 2 pi
/// ```
///
/// for angular velocities in the axes of the laboratory (Iserles, Munthe-Kaas, Nørsett & Zanna
/// 2000, appendix B).
fn inverse_differential(sigma: &Vector3<f64>, omega: &Vector3<f64>) -> Vector3<f64> {
    let angle = sigma.norm();
    // Below 1e-2 the relative error of the first two terms of the series is less than
    // angle^4 / 30240 = 1e-12.
    let g = if angle < 1e-2 {
        1.0 / 12.0 + angle * angle / 720.0
    } else {
        (1.0 - 0.5 * angle / (0.5 * angle).tan()) / (angle * angle)
    };
    let commutator = sigma.cross(omega);
    omega - 0.5 * commutator + g * sigma.cross(&commutator)
}

/// The rate of the coordinates `sigma` of a state that moves with `velocity`.
///
/// Translations and values of joints are vector spaces, so their rates are the velocities;
/// rotations are not. Attitudes that follow from a frame have no coordinates.
pub(super) fn coordinate_rate(
    set: &Articulation,
    sigma: &StateVelocity,
    velocity: &StateVelocity,
) -> StateVelocity {
    let frame = |(s, v): (&Twist, &Twist)| Twist {
        linear: v.linear,
        angular: inverse_differential(&s.angular, &v.angular),
    };
    StateVelocity {
        frames: sigma
            .frames
            .iter()
            .zip(&velocity.frames)
            .map(frame)
            .collect(),
        spins: sigma
            .spins
            .iter()
            .zip(&velocity.spins)
            .enumerate()
            .map(|(body, (s, w))| match set.has_own_attitude(body) {
                true => inverse_differential(s, w),
                false => Vector3::zeros(),
            })
            .collect(),
        joints: velocity.joints.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use nalgebra::UnitQuaternion;

    #[test]
    fn the_rate_of_the_rotation_vector_is_that_of_the_logarithm() {
        for scale in [1e-3, 0.009, 0.011, 0.5, 2.5] {
            let sigma = scale * Vector3::new(0.6, -0.3, 0.74);
            let omega = Vector3::new(-0.2, 0.5, 0.4);
            let after = |t: f64| {
                (UnitQuaternion::from_scaled_axis(t * omega)
                    * UnitQuaternion::from_scaled_axis(sigma))
                .scaled_axis()
            };
            // Central difference, fourth order: error about h^4 = 1e-12.
            let h = 1e-3;
            let difference =
                (8.0 * (after(h) - after(-h)) - (after(2.0 * h) - after(-2.0 * h))) / (12.0 * h);
            assert_abs_diff_eq!(
                inverse_differential(&sigma, &omega),
                difference,
                epsilon = 1e-11
            );
        }
    }
}
