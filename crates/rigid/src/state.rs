//! State of an articulated set, its velocity, and steps by the exponential map.

use std::ops::{Add, Mul};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::error::{check_finite, check_length};
use crate::{Articulation, RigidError};

/// Largest difference from 1 of the length of a quaternion that counts as a rotation.
///
/// [`Articulation::advance`] keeps it at the level of rounding; a text file with seven digits
/// reaches 1e-7.
const MAX_NORM_ERROR: f64 = 1e-6;

/// Position and attitude of an articulated set: one frame per linkage, one attitude per body.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct State {
    /// Pose of the frame of each linkage; its origin is the centre of the root body.
    pub frames: Vec<Isometry3<f64>>,
    /// Attitude of each body that has its own, relative to the laboratory axes; the identity at the
    /// start and for all other bodies.
    pub attitudes: Vec<UnitQuaternion<f64>>,
    /// Values of the passive joints, in the order of the joints.
    #[cfg_attr(feature = "serde", serde(default))]
    pub joints: Vec<f64>,
}

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
    /// The state of the positions given to [`Articulation::new`], all attitudes the identity.
    pub fn initial_state(&self) -> State {
        State {
            frames: self
                .linkages()
                .iter()
                .map(|linkage| {
                    Isometry3::from_parts(
                        Translation3::from(self.initial_positions()[linkage.root]),
                        UnitQuaternion::identity(),
                    )
                })
                .collect(),
            attitudes: vec![UnitQuaternion::identity(); self.kinds().len()],
            joints: (self.passive_drives())
                .map(|(joint, _)| self.initial_shape()[joint])
                .collect(),
        }
    }

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
        let vectors = frames.chain(&step.spins).flatten();
        check_finite("a velocity", vectors.chain(&step.joints))?;
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

    /// Refuses a state with another number of frames or attitudes than this set has, positions that
    /// are not finite and orientations that are not rotations.
    pub(crate) fn check_state(&self, state: &State) -> Result<(), RigidError> {
        check_length(
            "frames of the linkages",
            state.frames.len(),
            self.linkages().len(),
        )?;
        check_length(
            "attitudes of the bodies",
            state.attitudes.len(),
            self.kinds().len(),
        )?;
        check_length(
            "values of the passive joints",
            state.joints.len(),
            self.passive_drives().count(),
        )?;
        let positions = state.frames.iter().map(|frame| &frame.translation.vector);
        check_finite("the position of a frame", positions.flatten())?;
        let rotations = state.frames.iter().map(|frame| &frame.rotation);
        let mut norms = rotations.chain(&state.attitudes).map(|q| q.norm());
        let bad = |norm: &f64| norm.is_nan() || (norm - 1.0).abs() > MAX_NORM_ERROR;
        match norms.find(bad) {
            Some(length) => Err(RigidError::NotRotation { length }),
            None => Ok(()),
        }
    }
}

fn rotated(attitude: &UnitQuaternion<f64>, rotation: &Vector3<f64>) -> UnitQuaternion<f64> {
    let mut q = UnitQuaternion::from_scaled_axis(*rotation) * attitude;
    // The norm of a product of unit quaternions differs from 1 by rounding only, which accumulates
    // over many steps; one Newton step of the normalisation removes it.
    q.renormalize_fast();
    q
}
