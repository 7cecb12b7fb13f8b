//! Joints: the relative motions they allow (factors of a product of exponentials), drives and arms.
//!
//! Amplitudes of deformations are shape coordinates like the values of joints, and therefore joints
//! that move no body relative to another.
//! What depends on the kind of a joint stands here, in functions that list all kinds: a new kind
//! that is forgotten in one of them does not compile.

use nalgebra::{UnitQuaternion, Vector3};

use crate::RigidError;
use crate::error::{check_finite, is_finite};

/// A joint between two bodies.
///
/// ```
/// use rigid::{JointKind, JointDrive, Joint};
/// let arm = Joint::slide("left", 0, 1);
/// assert_eq!((arm.kind, arm.drive), (JointKind::Slide, JointDrive::Prescribed));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Joint {
    /// Name, for messages.
    pub name: String,
    /// The body at the far end: a growing length moves it away from `to`.
    pub body: usize,
    /// The body at the near end.
    pub to: usize,
    /// The relative motion that is possible.
    pub kind: JointKind,
    /// What determines the value of the joint.
    pub drive: JointDrive,
}

impl Joint {
    /// A joint of prescribed length between the centres of two bodies.
    pub fn slide(name: &str, body: usize, to: usize) -> Self {
        Self {
            name: name.to_owned(),
            body,
            to,
            kind: JointKind::Slide,
            drive: JointDrive::Prescribed,
        }
    }

    /// The same joint with another relative motion.
    #[must_use]
    pub fn with_kind(self, kind: JointKind) -> Self {
        Self { kind, ..self }
    }

    /// The same joint with another drive.
    #[must_use]
    pub fn with_drive(self, drive: JointDrive) -> Self {
        Self { drive, ..self }
    }

    /// Whether the value of the joint is part of the state and not prescribed.
    pub fn is_passive(&self) -> bool {
        self.passive_drive().is_some()
    }

    /// The force on the joint, if its value is part of the state.
    pub fn passive_drive(&self) -> Option<&PassiveDrive> {
        match &self.drive {
            JointDrive::Passive(drive) if self.kind.has_value() => Some(drive),
            _ => None,
        }
    }

    /// A shape coordinate that moves no body relative to another: the amplitude of a deformation,
    /// whose unit has this power of a length.
    ///
    /// `body` and `to` are the bodies that it deforms, twice the same for one.
    ///
    /// ```
    /// use rigid::{Freedom, Joint};
    /// let volume = Joint::deformation("ball.volume", [0, 0], 3);
    /// assert_eq!((volume.kind.freedom(), volume.kind.length_power()), (Freedom::Amplitude, 3));
    /// ```
    pub fn deformation(name: &str, [body, to]: [usize; 2], length_power: i32) -> Self {
        Self::slide(name, body, to).with_kind(JointKind::Deformation { length_power })
    }

    /// Refuses a kind or a drive that is not valid or that the arms do not allow.
    pub(crate) fn check(&self, arms: Arms) -> Result<(), RigidError> {
        let drive_is_valid = match &self.drive {
            JointDrive::Prescribed => true,
            JointDrive::Passive(drive) => drive.is_valid(),
        };
        let deforms = self.kind.freedom() == Freedom::Amplitude;
        let problem = match (&self.kind, arms) {
            _ if deforms && self.is_passive() => {
                "is the amplitude of a deformation, which has to be prescribed"
            }
            (kind, _) if !kind.is_valid() => {
                "has an axis that is no unit vector or a number that is not finite"
            }
            _ if !drive_is_valid => "has a drive that is not finite, or negative",
            (kind, Arms::Lab) if kind.turns() => {
                "turns, but with arms = lab all arms keep their directions; use clamped arms"
            }
            (kind, Arms::Free) if kind.has_attitude() => {
                "is a ball, but with arms = free bodies rotate already; use clamped arms"
            }
            _ => return Ok(()),
        };
        Err(RigidError::BadJoint {
            joint: self.name.clone(),
            problem,
        })
    }

    /// The arm in the initial configuration, and the initial value.
    pub(crate) fn initial_arm(
        &self,
        positions: &[Vector3<f64>],
    ) -> Result<(ArmVectors, f64), RigidError> {
        let (far, near) = (positions[self.body], positions[self.to]);
        let arm = far - near;
        let to_pivot = |direction, pivot: &Vector3<f64>| ArmVectors {
            direction,
            near: pivot - near,
            far: pivot - far,
        };
        match &self.kind {
            JointKind::Turn { axis, pivot, .. } => Ok((to_pivot(*axis, pivot), 0.0)),
            JointKind::Ball { pivot } => Ok((to_pivot(Vector3::zeros(), pivot), 0.0)),
            JointKind::Deformation { .. } => Ok((to_pivot(Vector3::zeros(), &near), 0.0)),
            JointKind::Slide | JointKind::Fixed => {
                let distance = arm.norm();
                check_finite("the distance between two linked bodies", [&distance])?;
                let vectors = |direction| ArmVectors {
                    direction,
                    near: arm,
                    far: Vector3::zeros(),
                };
                if self.kind == JointKind::Fixed {
                    return Ok((vectors(Vector3::zeros()), 0.0));
                }
                // A distance at the level of rounding of the positions determines no direction.
                let scale = far.norm().max(near.norm());
                if distance <= 1e-12 * scale || distance == 0.0 {
                    return Err(RigidError::NoDirection {
                        joint: self.name.clone(),
                        distance,
                    });
                }
                Ok((vectors(arm / distance), distance))
            }
        }
    }
}

/// Attachment of bodies to arms that rotate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Arms {
    /// Bodies do not rotate relative to their frame: one angular velocity for each frame.
    #[default]
    Clamped,
    /// Each body rotates torque-free, and so does each frame.
    Free,
    /// Arms keep their direction in the laboratory axes and bodies rotate freely.
    ///
    /// This is the literal reading of equations (11)-(12) of Berti et al. (2021). It is torque-free
    /// only if the swimmer is collinear and moves along its axis.
    Lab,
}

/// What a joint needs to place its bodies, in the axes of their frames.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArmVectors {
    /// Unit vector along which the value of the joint acts: from `to` to `body` for slides.
    pub direction: Vector3<f64>,
    /// From the centre of `to` to the pivot; to the centre of `body` for slides and fixed joints.
    pub near: Vector3<f64>,
    /// From the centre of `body` to the pivot; zero for slides and fixed joints.
    pub far: Vector3<f64>,
}

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
    /// Neither a relative motion nor a constraint: the value is the amplitude of a deformation of
    /// `body` and `to`, zero at the start unless [`Articulation::with_initial_values`] says
    /// otherwise.
    ///
    /// [`Articulation::with_initial_values`]: crate::Articulation::with_initial_values
    Deformation {
        /// Power of a length that is the unit of the amplitude: three of a volume, zero of a
        /// number.
        length_power: i32,
    },
}

/// The relative motion that a joint leaves free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Freedom {
    /// No relative motion.
    Nothing,
    /// The distance of the centres, a positive length.
    Distance,
    /// The angle about an axis.
    Angle,
    /// The rotation, which is part of the state and no value of the joint.
    Rotation,
    /// The amplitude of a deformation, which moves no body relative to another.
    Amplitude,
}

impl JointKind {
    /// The relative motion that the joint leaves free.
    pub fn freedom(&self) -> Freedom {
        match self {
            Self::Slide => Freedom::Distance,
            Self::Fixed => Freedom::Nothing,
            Self::Turn { .. } => Freedom::Angle,
            Self::Ball { .. } => Freedom::Rotation,
            Self::Deformation { .. } => Freedom::Amplitude,
        }
    }

    /// Power of a length that is the unit of the value: one of slides, zero of angles.
    pub fn length_power(&self) -> i32 {
        match self {
            Self::Slide => 1,
            Self::Fixed | Self::Turn { .. } | Self::Ball { .. } => 0,
            Self::Deformation { length_power } => *length_power,
        }
    }

    /// Whether values may have any sign: angles and amplitudes that are numbers; lengths and
    /// volumes are positive.
    pub fn is_signed(&self) -> bool {
        self.length_power() == 0
    }

    /// Whether the value is the amplitude of a deformation.
    pub fn is_deformation(&self) -> bool {
        self.freedom() == Freedom::Amplitude
    }

    /// Whether the value is an angle and not a length.
    pub fn is_angle(&self) -> bool {
        self.freedom() == Freedom::Angle
    }

    /// Whether the two bodies can rotate relative to each other.
    pub fn turns(&self) -> bool {
        matches!(self.freedom(), Freedom::Angle | Freedom::Rotation)
    }

    /// Whether a gait or a drive can change the value.
    pub fn has_value(&self) -> bool {
        !matches!(self.freedom(), Freedom::Nothing | Freedom::Rotation)
    }

    /// Whether the flow determines the relative rotation, which is then part of the state.
    pub fn has_attitude(&self) -> bool {
        self.freedom() == Freedom::Rotation
    }

    /// Whether rows constrain the relative rotation of the two frames.
    pub(crate) fn constrains_rotation(&self) -> bool {
        self.freedom() == Freedom::Angle
    }

    /// Number of scalar constraints: three of the relative translation, three of the rotation.
    pub(crate) fn rows(&self) -> usize {
        match self.freedom() {
            Freedom::Amplitude => 0,
            Freedom::Angle => 6,
            Freedom::Nothing | Freedom::Distance | Freedom::Rotation => 3,
        }
    }

    /// Whether the value can be reached: lengths and volumes are positive.
    pub(crate) fn admits(&self, value: f64) -> bool {
        value.is_finite() && (value > 0.0 || self.is_signed() || !self.has_value())
    }

    /// The same joint in another unit of length: all lengths are multiplied by `factor`.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        match &mut self {
            Self::Slide | Self::Fixed | Self::Deformation { .. } => {}
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
        match &mut self {
            Self::Slide | Self::Fixed | Self::Deformation { .. } => {}
            Self::Turn { pivot, .. } | Self::Ball { pivot } => *pivot += shift,
        }
        self
    }

    /// Rotation of the frame of `body` relative to that of `to` at a value, for all but balls.
    pub(crate) fn rotation(&self, value: f64) -> UnitQuaternion<f64> {
        match self {
            Self::Turn { axis, .. } => UnitQuaternion::from_scaled_axis(value * axis),
            Self::Slide | Self::Fixed | Self::Ball { .. } | Self::Deformation { .. } => {
                UnitQuaternion::identity()
            }
        }
    }

    /// Whether bodies and joint stay symmetric about the plane through the origin normal to a
    /// coordinate axis: joints that turn keep a plane if they turn within it.
    pub fn keeps_plane(&self, normal: usize) -> bool {
        match self {
            Self::Slide | Self::Fixed | Self::Deformation { .. } => true,
            Self::Ball { pivot } => pivot[normal] == 0.0,
            Self::Turn {
                axis,
                pivot,
                advance,
            } => {
                let in_plane = (0..3).filter(|&other| other != normal);
                pivot[normal] == 0.0
                    && *advance == 0.0
                    && in_plane.map(|k| axis[k]).all(|a| a == 0.0)
            }
        }
    }

    /// Whether bodies on the line through `point` along the unit vector `direction` stay on it;
    /// distances up to `tolerance` count as zero.
    pub fn keeps_line(
        &self,
        point: &Vector3<f64>,
        direction: &Vector3<f64>,
        tolerance: f64,
    ) -> bool {
        match self {
            Self::Slide | Self::Fixed | Self::Deformation { .. } => true,
            Self::Ball { .. } => false,
            Self::Turn { axis, pivot, .. } => {
                let distance = (pivot - point).cross(direction).norm();
                axis.cross(direction).norm() <= 1e-9 && distance <= tolerance
            }
        }
    }

    /// Vector from the centre of `to` to that of `body` at a value, from the rotations of the
    /// frames of `to` (near) and `body` (far).
    pub(crate) fn arm(
        &self,
        value: f64,
        vectors: &ArmVectors,
        near: &UnitQuaternion<f64>,
        far: &UnitQuaternion<f64>,
    ) -> Vector3<f64> {
        match self {
            Self::Slide => value * (near * vectors.direction),
            Self::Fixed => near * vectors.near,
            Self::Turn { advance, .. } => {
                near * (vectors.near + advance * value * vectors.direction) - far * vectors.far
            }
            Self::Ball { .. } => near * vectors.near - far * vectors.far,
            Self::Deformation { .. } => Vector3::zeros(),
        }
    }

    /// Relative velocity of the frames at the pivot per rate of the value, and relative angular
    /// velocity if the joint constrains it; `direction` is that of the joint now.
    pub(crate) fn twist(&self, direction: Vector3<f64>) -> (Vector3<f64>, Option<Vector3<f64>>) {
        match self {
            Self::Slide => (direction, None),
            Self::Fixed | Self::Ball { .. } | Self::Deformation { .. } => (Vector3::zeros(), None),
            Self::Turn { advance, .. } => (*advance * direction, Some(direction)),
        }
    }

    /// Largest distance of the two bodies at a value.
    pub(crate) fn arm_length(&self, value: f64, vectors: &ArmVectors) -> f64 {
        match self {
            Self::Slide => value.abs(),
            Self::Fixed | Self::Turn { .. } | Self::Ball { .. } | Self::Deformation { .. } => {
                vectors.near.norm() + vectors.far.norm()
            }
        }
    }

    /// Largest displacement of one body relative to the other per change of the value.
    pub(crate) fn lever(&self, vectors: &ArmVectors) -> f64 {
        match self {
            Self::Slide => 1.0,
            Self::Turn { advance, .. } => {
                vectors.near.norm().max(vectors.far.norm()) + advance.abs()
            }
            Self::Fixed | Self::Ball { .. } | Self::Deformation { .. } => 0.0,
        }
    }

    /// Whether all numbers are finite and the axis is a unit vector.
    pub(crate) fn is_valid(&self) -> bool {
        match self {
            Self::Slide | Self::Fixed | Self::Deformation { .. } => true,
            Self::Turn {
                axis,
                pivot,
                advance,
            } => is_finite(pivot) && advance.is_finite() && (axis.norm() - 1.0).abs() <= 1e-9,
            Self::Ball { pivot } => is_finite(pivot),
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
