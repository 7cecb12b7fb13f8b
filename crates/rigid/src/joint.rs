//! Joints: how a joint lets its two bodies move relative to each other.

use nalgebra::{UnitQuaternion, Vector3};

/// The relative motion that a joint allows, in the pose of its bodies at the start.
///
/// Axes and pivots are given in the laboratory axes at the start and then move with the arms of the
/// joint. With `g(v)` the pose of `body` relative to `to` at the value `v` of the joint, `g` is a
/// product of exponentials (Murray, Li & Sastry 1994, A Mathematical Introduction to Robotic
/// Manipulation, section 3.2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum JointKind {
    /// The distance of the centres changes along their line. The value is the distance.
    #[default]
    Slide,
    /// No relative motion. The value is zero.
    Fixed,
    /// Rotation about an axis, and with `advance` also translation along it. The value is the angle
    /// in radians, zero at the start; a positive one turns `body` counterclockwise about `axis`.
    Turn {
        /// Unit vector along the axis.
        axis: Vector3<f64>,
        /// A point of the axis.
        pivot: Vector3<f64>,
        /// Translation along the axis per radian: zero for hinges and rotors, not for screws.
        advance: f64,
    },
    /// Free rotation about a point. It has no value: flow and loads determine the rotation.
    Ball {
        /// The point.
        pivot: Vector3<f64>,
    },
}

impl JointKind {
    /// Whether the value is an angle and not a length.
    pub fn is_angle(&self) -> bool {
        matches!(self, Self::Turn { .. })
    }

    /// Whether the two bodies can rotate relative to each other.
    pub fn turns(&self) -> bool {
        matches!(self, Self::Turn { .. } | Self::Ball { .. })
    }

    /// Whether a gait or a drive can change the value.
    pub fn has_value(&self) -> bool {
        matches!(self, Self::Slide | Self::Turn { .. })
    }

    /// The same joint in another unit of length: all lengths are multiplied by `factor`.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        match &mut self {
            Self::Slide | Self::Fixed => {}
            Self::Turn { pivot, advance, .. } => {
                *pivot *= factor;
                *advance *= factor;
            }
            Self::Ball { pivot } => *pivot *= factor,
        }
        self
    }

    /// The same joint of bodies that are elsewhere by `shift`.
    #[must_use]
    pub fn translated(mut self, shift: &Vector3<f64>) -> Self {
        if let Self::Turn { pivot, .. } | Self::Ball { pivot } = &mut self {
            *pivot += shift;
        }
        self
    }

    /// Number of scalar constraints: three of the relative translation, three of the rotation.
    pub(crate) fn rows(&self) -> usize {
        match self {
            Self::Slide | Self::Fixed | Self::Ball { .. } => 3,
            Self::Turn { .. } => 6,
        }
    }

    /// Rotation of the frame of `body` relative to that of `to` at a value, for all but balls.
    pub(crate) fn rotation(&self, value: f64) -> UnitQuaternion<f64> {
        match self {
            Self::Turn { axis, .. } => UnitQuaternion::from_scaled_axis(value * axis),
            _ => UnitQuaternion::identity(),
        }
    }

    /// Whether all numbers are finite and the axis is a unit vector.
    pub(crate) fn is_valid(&self) -> bool {
        let finite = |v: &Vector3<f64>| v.iter().all(|x| x.is_finite());
        match self {
            Self::Slide | Self::Fixed => true,
            Self::Turn {
                axis,
                pivot,
                advance,
            } => finite(pivot) && advance.is_finite() && (axis.norm() - 1.0).abs() <= 1e-9,
            Self::Ball { pivot } => finite(pivot),
        }
    }
}

/// What determines the value of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum JointDrive {
    /// A gait prescribes it; the force that this takes is a result.
    #[default]
    Prescribed,
    /// A force acts on it (a torque, for angles) and the motion is a result:
    /// `force - stiffness (v - rest) - damping dv/dt` at the value `v`.
    Passive(PassiveDrive),
}

/// The force on a joint whose value is not prescribed; all zero for a joint that moves freely.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PassiveDrive {
    /// Constant force or torque; a positive one increases the value.
    pub force: f64,
    /// Stiffness of a spring.
    pub stiffness: f64,
    /// Value at which the spring has no force.
    pub rest: f64,
    /// Coefficient of a dashpot.
    pub damping: f64,
}

impl PassiveDrive {
    /// Force at a value, without that of the dashpot.
    pub fn static_force(&self, value: f64) -> f64 {
        // A spring without stiffness has no force, whatever its rest value is.
        match self.stiffness {
            0.0 => self.force,
            stiffness => self.force - stiffness * (value - self.rest),
        }
    }

    /// Whether all numbers are finite, and stiffness and damping not negative.
    pub(crate) fn is_valid(&self) -> bool {
        let all = [self.force, self.stiffness, self.rest, self.damping];
        all.iter().all(|x| x.is_finite()) && self.stiffness >= 0.0 && self.damping >= 0.0
    }
}
