//! Joints in the initial configuration: checks of their kinds, and the vectors that place bodies.

use nalgebra::Vector3;

use crate::joint::{JointDrive, JointKind};
use crate::linkage::Joint;
use crate::{Arms, RigidError};

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

/// Refuses joints and drives that are not valid or that the arms do not allow.
pub(crate) fn check_joint(joint: &Joint, arms: Arms) -> Result<(), RigidError> {
    let drive_is_valid = match &joint.drive {
        JointDrive::Prescribed => true,
        JointDrive::Passive(drive) => drive.is_valid(),
    };
    let problem = match (&joint.kind, arms) {
        (kind, _) if !kind.is_valid() => {
            "has an axis that is no unit vector or a number that is not finite"
        }
        _ if !drive_is_valid => "has a drive that is not finite, or negative",
        (kind, Arms::Lab) if kind.turns() => {
            "turns, but with arms = lab all arms keep their directions; use clamped arms"
        }
        (JointKind::Ball { .. }, Arms::Free) => {
            "is a ball, but with arms = free bodies rotate already; use clamped arms"
        }
        _ => return Ok(()),
    };
    Err(RigidError::BadJoint {
        joint: joint.name.clone(),
        problem,
    })
}

/// The arm of a joint in the initial configuration, and its initial value.
pub(crate) fn arm_of(
    joint: &Joint,
    positions: &[Vector3<f64>],
) -> Result<(ArmVectors, f64), RigidError> {
    let (far, near) = (positions[joint.body], positions[joint.to]);
    let arm = far - near;
    let to_pivot = |direction, pivot: &Vector3<f64>| ArmVectors {
        direction,
        near: pivot - near,
        far: pivot - far,
    };
    match &joint.kind {
        JointKind::Turn { axis, pivot, .. } => Ok((to_pivot(*axis, pivot), 0.0)),
        JointKind::Ball { pivot } => Ok((to_pivot(Vector3::zeros(), pivot), 0.0)),
        JointKind::Slide | JointKind::Fixed => {
            let distance = arm.norm();
            if !distance.is_finite() {
                return Err(RigidError::NotFinite {
                    what: "the distance between two linked bodies",
                });
            }
            let vectors = |direction| ArmVectors {
                direction,
                near: arm,
                far: Vector3::zeros(),
            };
            if joint.kind == JointKind::Fixed {
                return Ok((vectors(Vector3::zeros()), 0.0));
            }
            // A distance at the level of rounding of the positions determines no direction.
            let scale = far.norm().max(near.norm());
            if distance <= 1e-12 * scale || distance == 0.0 {
                return Err(RigidError::NoDirection {
                    joint: joint.name.clone(),
                    distance,
                });
            }
            Ok((vectors(arm / distance), distance))
        }
    }
}
