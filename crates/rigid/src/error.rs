//! Errors of bodies, joints, constraints and fluid matrices.

use nalgebra::Vector3;

/// Reason why bodies, joints or matrices cannot be used, with the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RigidError {
    /// A joint to a body that does not exist.
    #[error("link '{joint}' refers to body {body}, but there are only {bodies} bodies")]
    NoSuchBody {
        /// Name of the joint.
        joint: String,
        /// Index of the body that the joint names.
        body: usize,
        /// Number of bodies.
        bodies: usize,
    },
    /// A joint that does not exist, or whose load is not known.
    #[error("there is no link {joint}: loads of {joints} links are known")]
    NoSuchJoint {
        /// Index of the joint.
        joint: usize,
        /// Number of joints with a load.
        joints: usize,
    },
    /// A joint from a body to itself or between two bodies at the same position.
    #[error(
        "link '{joint}' has no direction: its ends are {distance:.3e} apart; link two bodies at \
         different positions"
    )]
    NoDirection {
        /// Name of the joint.
        joint: String,
        /// Distance between the two ends.
        distance: f64,
    },
    /// A rigid surface that is not where its body is.
    #[error(
        "body {body} is {distance:.3e} away from the centre of its surface; use the mesh of this \
         configuration, and list the surfaces in the order of the bodies"
    )]
    Misplaced {
        /// Index of the body among those with a surface.
        body: usize,
        /// Distance between the position of the body and the centre of the surface.
        distance: f64,
    },
    /// A rigid surface that encloses no volume.
    #[error(
        "the surface of body {body} encloses the volume {volume:.3e}, which must be positive; its \
         facets may be oriented the wrong way"
    )]
    BadVolume {
        /// Index of the body among those with a surface.
        body: usize,
        /// The volume.
        volume: f64,
    },
    /// An orientation that is not a rotation.
    #[error("an orientation is a quaternion of length {length}, which must be 1")]
    NotRotation {
        /// Length of the quaternion.
        length: f64,
    },
    /// Constraints that belong to another articulated set.
    #[error(
        "the constraints belong to another articulated set, or were changed; compute them by \
         Articulation::constraints of this set"
    )]
    OtherSet,
    /// A load that is not symmetric about the symmetry planes.
    #[error(
        "the force or torque on body {body} is not symmetric about the symmetry planes; solve on \
         the whole mesh"
    )]
    AsymmetricLoad {
        /// Index of the body.
        body: usize,
    },
    /// A rigid body whose centre is not on every symmetry plane.
    #[error(
        "the centre of rigid body {body} is {distance:.3e} away from a symmetry plane; solve on \
         the whole mesh"
    )]
    OffSymmetryPlane {
        /// Index of the body among those with a surface.
        body: usize,
        /// Distance of its centre from the plane.
        distance: f64,
    },
    /// A wall velocity with a component normal to a symmetry plane that the node lies on.
    #[error(
        "the wall velocity at node {node} crosses a symmetry plane at {normal:.3e}; solve on the \
         whole mesh"
    )]
    AsymmetricWallVelocity {
        /// Index of the node.
        node: usize,
        /// Component of the velocity normal to the plane.
        normal: f64,
    },
    /// Wall velocities that push a net volume into or out of an enclosed fluid.
    #[error(
        "the wall velocities have a net flux of {flux:.3e} (relative size {relative:.1e}) through \
         the boundary of an enclosed fluid, so no incompressible flow has them; subtract the mean \
         normal velocity from them"
    )]
    NetWallFlux {
        /// Sum of the discrete fluxes, `sum_q (B u_W)_q`.
        flux: f64,
        /// The sum over the sum of the absolute values of its terms.
        relative: f64,
    },
    /// A point without a joint: nothing resists its motion, so its velocity is undetermined.
    #[error(
        "point {body} is not linked to any body, so its velocity is undetermined; link it or \
         remove it"
    )]
    LoosePoint {
        /// Index of the point.
        body: usize,
    },
    /// Joints in a loop whose prescribed velocities contradict each other.
    #[error(
        "the links contradict each other: the velocity that '{joint}' prescribes differs by \
         {mismatch:.3e} from the one that the others imply; in a loop the rates must add up to zero"
    )]
    IncompatibleJoints {
        /// Name of the joint whose constraint fails.
        joint: String,
        /// Residual of the constraint, a velocity.
        mismatch: f64,
    },
    /// A length that is zero, negative or not finite.
    #[error("link '{joint}' has length {length}; lengths must be positive")]
    BadLength {
        /// Name of the joint.
        joint: String,
        /// The length.
        length: f64,
    },
    /// Loads on a motion that moves no surface: its velocity would be infinite.
    #[error(
        "loads act on a motion that moves no surface, so that no fluid resists it (power \
         {power:.3e} at unit speed); give the moving part a body or remove the load, spring or \
         force"
    )]
    Unresisted {
        /// Power of the loads at unit speed of the motion.
        power: f64,
    },
    /// A joint that is not valid, or that does not fit the arms.
    #[error("the joint of link '{joint}' {problem}")]
    BadJoint {
        /// Name of the joint.
        joint: String,
        /// The reason.
        problem: &'static str,
    },
    /// A loop of joints that does not close at the given values.
    #[error(
        "the loop closed by link '{joint}' does not meet: its ends are {gap:.3e} away from the \
         link's length and direction"
    )]
    OpenLoop {
        /// Name of the joint.
        joint: String,
        /// Distance by which the loop stays open.
        gap: f64,
    },
    /// A body whose velocity cannot be given.
    #[error("body {body} cannot be held: {problem}")]
    HeldBody {
        /// Index of the body.
        body: usize,
        /// The reason.
        problem: &'static str,
    },
    /// A held body in the formulation of independent bodies, which has no constraints.
    #[error(
        "the velocity of body {body} is given, which the formulation of independent bodies cannot impose; choose \
         a formulation with constraints, such as p-tilde"
    )]
    HeldWithoutConstraint {
        /// Index of the body.
        body: usize,
    },
    /// A joint in the formulation of independent bodies, which has no constraints.
    #[error(
        "the formulation of independent bodies cannot impose link '{joint}'; choose a formulation \
         with constraints, such as p-tilde"
    )]
    JointWithoutConstraint {
        /// Name of the joint.
        joint: String,
    },
    /// A fluid without any node of prescribed velocity.
    #[error(
        "no node has a prescribed velocity: without a wall, velocities are determined only up to \
         a rigid motion of the whole fluid; make some boundary a no-slip wall"
    )]
    NoWall,
    /// A rigid body without any node on its surface.
    #[error(
        "body {body} has no node on its surface, so nothing resists its motion; give some nodes \
         the role of its surface"
    )]
    NoSurface {
        /// Index among the bodies with surfaces.
        body: usize,
    },
    /// A system of another formulation where that of independent bodies is needed.
    #[error(
        "only the formulation of independent bodies can be condensed on them; build the system \
         with Independent and without links"
    )]
    NotIndependent,
    /// Joints, values or loads other than those that a system was built with.
    #[error(
        "a system can be reused for other rates of its links only; build another one for other \
         links, lengths or loads"
    )]
    OtherJoints,
    /// A mobility matrix that is not positive definite.
    #[error(
        "the mobility of the bodies is not positive definite (asymmetry {asymmetry:.1e}): the \
         solves were not accurate enough; use a smaller tolerance"
    )]
    NotPositiveDefinite {
        /// Largest difference from its transpose over its largest entry.
        asymmetry: f64,
    },
    /// Constraints that are linearly dependent to rounding, so that joint loads are not unique.
    #[error(
        "the loads of the links are not unique: their constraints are linearly dependent to \
         rounding; remove a redundant link or check nearly parallel ones"
    )]
    DependentConstraints,
    /// An array or matrix of the wrong size.
    #[error("{what}: expected {expected}, found {found}")]
    Length {
        /// Name of the items that are counted.
        what: &'static str,
        /// Expected number.
        expected: usize,
        /// Number found.
        found: usize,
    },
    /// A number that is not finite.
    #[error("{what} is not finite")]
    NotFinite {
        /// Name of the number.
        what: &'static str,
    },
    /// Assembled matrices that do not fit together, or that a solver cannot treat.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
}

/// Refuses an array of the wrong length.
pub(crate) fn check_length(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), RigidError> {
    if found == expected {
        Ok(())
    } else {
        Err(RigidError::Length {
            what,
            expected,
            found,
        })
    }
}

/// Refuses numbers that are not finite.
pub(crate) fn check_finite<'n>(
    what: &'static str,
    numbers: impl IntoIterator<Item = &'n f64>,
) -> Result<(), RigidError> {
    match numbers.into_iter().all(|number| number.is_finite()) {
        true => Ok(()),
        false => Err(RigidError::NotFinite { what }),
    }
}

/// Whether all components are finite.
pub(crate) fn is_finite(vector: &Vector3<f64>) -> bool {
    vector.iter().all(|component| component.is_finite())
}
