//! Velocities of an articulated set, and the exponential map that advances its state.

use std::ops::{Add, Mul};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::error::check_length;
use crate::placement::is_finite;
use crate::{Articulation, RigidError, State};

/// Linear and angular velocity of a rigid body or frame, in the laboratory axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Twist {
    /// Velocity of the centre of the body or the origin of the frame.
    pub linear: Vector3<f64>,
    /// Angular velocity.
    pub angular: Vector3<f64>,
}

/// Rate of change of a [`State`]: one twist per linkage, one angular velocity per body, one rate
/// per passive joint.
///
/// A sum has as many twists as the shorter of its terms; [`Articulation::advance`] refuses a number
/// that does not fit the set.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct StateVelocity {
    /// Twist of the frame of each linkage; the linear part is the velocity of the root body.
    pub frames: Vec<Twist>,
    /// Angular velocity of each body.
    pub spins: Vec<Vector3<f64>>,
    /// Rates of the joints that are not prescribed.
    #[cfg_attr(feature = "serde", serde(default))]
    pub joints: Vec<f64>,
}

impl Add for Twist {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            linear: self.linear + other.linear,
            angular: self.angular + other.angular,
        }
    }
}

impl Mul<f64> for Twist {
    type Output = Self;
    fn mul(self, factor: f64) -> Self {
        Self {
            linear: self.linear * factor,
            angular: self.angular * factor,
        }
    }
}

impl Add for &StateVelocity {
    type Output = StateVelocity;
    fn add(self, other: Self) -> StateVelocity {
        StateVelocity {
            frames: self
                .frames
                .iter()
                .zip(&other.frames)
                .map(|(&a, &b)| a + b)
                .collect(),
            spins: self
                .spins
                .iter()
                .zip(&other.spins)
                .map(|(a, b)| a + b)
                .collect(),
            joints: (self.joints.iter().zip(&other.joints))
                .map(|(a, b)| a + b)
                .collect(),
        }
    }
}

impl Mul<f64> for &StateVelocity {
    type Output = StateVelocity;
    fn mul(self, factor: f64) -> StateVelocity {
        StateVelocity {
            frames: self.frames.iter().map(|&t| t * factor).collect(),
            spins: self.spins.iter().map(|w| w * factor).collect(),
            joints: self.joints.iter().map(|rate| rate * factor).collect(),
        }
    }
}

impl Articulation {
    /// The state after one unit of time at the constant velocity `step`.
    ///
    /// Positions and attitudes are advanced on `R^3 × SO(3)`: `x + U` and `exp(ω) Q`, both in the
    /// laboratory axes. The exponential is exact for any step, and attitudes stay rotations. Those
    /// that follow from a frame do not change ([`Articulation::has_own_attitude`]).
    ///
    /// # Errors
    /// Arrays whose lengths do not fit the set, or a velocity or a new state that is not finite.
    pub fn advance(&self, state: &State, step: &StateVelocity) -> Result<State, RigidError> {
        self.check_state(state)?;
        check_length("frame velocities", step.frames.len(), state.frames.len())?;
        check_length(
            "angular velocities of the bodies",
            step.spins.len(),
            state.attitudes.len(),
        )?;
        check_length(
            "rates of the passive joints",
            step.joints.len(),
            state.joints.len(),
        )?;
        let frames = step.frames.iter().flat_map(|t| [&t.linear, &t.angular]);
        let joints_are_finite = step.joints.iter().all(|rate| rate.is_finite());
        if !(frames.chain(&step.spins).all(is_finite) && joints_are_finite) {
            return Err(RigidError::NotFinite { what: "a velocity" });
        }
        let next = State {
            frames: state
                .frames
                .iter()
                .zip(&step.frames)
                .map(|(frame, twist)| {
                    Isometry3::from_parts(
                        Translation3::from(frame.translation.vector + twist.linear),
                        rotated(&frame.rotation, &twist.angular),
                    )
                })
                .collect(),
            attitudes: state
                .attitudes
                .iter()
                .zip(&step.spins)
                .enumerate()
                .map(|(body, (q, w))| match self.has_own_attitude(body) {
                    true => rotated(q, w),
                    false => *q,
                })
                .collect(),
            joints: (state.joints.iter().zip(&step.joints))
                .map(|(value, change)| value + change)
                .collect(),
        };
        self.check_state(&next)?;
        Ok(next)
    }
}

fn rotated(attitude: &UnitQuaternion<f64>, rotation: &Vector3<f64>) -> UnitQuaternion<f64> {
    let mut q = UnitQuaternion::from_scaled_axis(*rotation) * attitude;
    // The norm of a product of unit quaternions differs from 1 by rounding only, which accumulates
    // over many steps; one Newton step of the normalisation removes it.
    q.renormalize_fast();
    q
}
