//! Links in the initial configuration: checks of their joints, and the vectors that place bodies.

use nalgebra::Vector3;

use crate::joint::{Joint, JointDrive};
use crate::linkage::Link;
use crate::{Arms, RigidError};

/// What a link needs to place its bodies, in the axes of their frames.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArmVectors {
    /// Unit vector along which the value of the joint acts: from `to` to `body` for slides.
    pub direction: Vector3<f64>,
    /// From the centre of `to` to the pivot; to the centre of `body` for slides and fixed links.
    pub near: Vector3<f64>,
    /// From the centre of `body` to the pivot; zero for slides and fixed links.
    pub far: Vector3<f64>,
}

/// Refuses joints and drives that are not valid or that the arms do not allow.
pub(crate) fn check_joint(link: &Link, arms: Arms) -> Result<(), RigidError> {
    let drive_is_valid = match &link.drive {
        JointDrive::Prescribed => true,
        JointDrive::Passive(drive) => drive.is_valid(),
    };
    let problem = match (&link.joint, arms) {
        (joint, _) if !joint.is_valid() => {
            "has an axis that is no unit vector or a number that is not finite"
        }
        _ if !drive_is_valid => "has a drive that is not finite, or negative",
        (joint, Arms::Lab) if joint.turns() => {
            "turns, but with arms = lab all arms keep their directions; use clamped arms"
        }
        (Joint::Ball { .. }, Arms::Free) => {
            "is a ball, but with arms = free bodies rotate already; use clamped arms"
        }
        _ => return Ok(()),
    };
    Err(RigidError::BadJoint {
        link: link.name.clone(),
        problem,
    })
}

/// The arm of a link in the initial configuration, and the initial value of its joint.
pub(crate) fn arm_of(
    link: &Link,
    positions: &[Vector3<f64>],
) -> Result<(ArmVectors, f64), RigidError> {
    let (far, near) = (positions[link.body], positions[link.to]);
    let arm = far - near;
    let to_pivot = |direction, pivot: &Vector3<f64>| ArmVectors {
        direction,
        near: pivot - near,
        far: pivot - far,
    };
    match &link.joint {
        Joint::Turn { axis, pivot, .. } => Ok((to_pivot(*axis, pivot), 0.0)),
        Joint::Ball { pivot } => Ok((to_pivot(Vector3::zeros(), pivot), 0.0)),
        Joint::Slide | Joint::Fixed => {
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
            if link.joint == Joint::Fixed {
                return Ok((vectors(Vector3::zeros()), 0.0));
            }
            // A distance at the level of rounding of the positions determines no direction.
            let scale = far.norm().max(near.norm());
            if distance <= 1e-12 * scale || distance == 0.0 {
                return Err(RigidError::NoDirection {
                    link: link.name.clone(),
                    distance,
                });
            }
            Ok((vectors(arm / distance), distance))
        }
    }
}
