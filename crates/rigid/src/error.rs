//! What can go wrong with bodies, links and their constraints.

/// A set of bodies and links that cannot move as asked, with the names and the remedy.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RigidError {
    /// A link that names a body that does not exist.
    #[error("link '{link}' names body {body}, but there are only {bodies} bodies")]
    NoSuchBody {
        /// Name of the link.
        link: String,
        /// Index asked for.
        body: usize,
        /// Number of bodies.
        bodies: usize,
    },
    /// A link from a body to itself or between two bodies at one place.
    #[error(
        "link '{link}' has no direction: its ends are {distance:.3e} apart; link two bodies at different places"
    )]
    NoDirection {
        /// Name of the link.
        link: String,
        /// Distance of the two ends.
        distance: f64,
    },
    /// A load that mirror planes do not map onto itself.
    #[error(
        "the force or torque on body {body} is not its own mirror image; solve on the whole mesh"
    )]
    AsymmetricLoad {
        /// Index of the body.
        body: usize,
    },
    /// A body that a mirror plane does not cut in halves.
    #[error(
        "the centre of rigid body {body} is {distance:.3e} away from a mirror plane; solve on the whole mesh"
    )]
    OffSymmetryPlane {
        /// Number of the body among those with a surface.
        body: usize,
        /// Distance of its centre from the plane.
        distance: f64,
    },
    /// A point that no link holds has no resistance, so its velocity is undetermined.
    #[error(
        "point {body} is not linked to any body, so nothing determines its velocity; link it or remove it"
    )]
    LoosePoint {
        /// Index of the point.
        body: usize,
    },
    /// Links that close a loop but ask for velocities that do not close.
    #[error(
        "the links contradict each other: link '{link}' misses the velocity that the others imply by {mismatch:.3e}; \
         in a loop the rates must add up to zero around it"
    )]
    IncompatibleLinks {
        /// Name of the link whose constraint fails.
        link: String,
        /// Velocity by which it fails.
        mismatch: f64,
    },
    /// A length that is zero, negative or not finite.
    #[error("link '{link}' has length {length}; lengths must be positive")]
    BadLength {
        /// Name of the link.
        link: String,
        /// The length.
        length: f64,
    },
    /// A loop of links whose lengths do not meet.
    #[error(
        "the loop closed by link '{link}' does not meet: its ends are {gap:.3e} away from the link's length and direction"
    )]
    OpenLoop {
        /// Name of the link.
        link: String,
        /// Distance by which the loop stays open.
        gap: f64,
    },
    /// A body that cannot be held still.
    #[error("body {body} cannot be fixed: {problem}")]
    FixedBody {
        /// Index of the body.
        body: usize,
        /// Why not.
        problem: &'static str,
    },
    /// Independent bodies were asked for, but one is held still.
    #[error(
        "body {body} is fixed, which independent bodies cannot be; choose a formulation with constraints, such as p-tilde"
    )]
    FixedWithoutConstraint {
        /// Index of the body.
        body: usize,
    },
    /// Independent bodies were asked for, but there is a link.
    #[error(
        "link '{link}' cannot be imposed on independent bodies; choose a formulation with constraints, such as p-tilde"
    )]
    LinkWithoutConstraint {
        /// Name of the link.
        link: String,
    },
    /// A fluid that nothing holds.
    #[error(
        "no node is held: without a wall, velocities are determined only up to a rigid motion of everything; give some boundary no slip"
    )]
    NoWall,
    /// A body that no node of the mesh belongs to.
    #[error(
        "body {body} has no node on its surface, so nothing resists its motion; give it the tag of a surface"
    )]
    NoSurface {
        /// Index among the bodies with surfaces.
        body: usize,
    },
    /// A system of another formulation where that of independent bodies is needed.
    #[error(
        "only the formulation of independent bodies can be condensed on them; build the system with Independent and without links"
    )]
    NotIndependent,
    /// Other links, lengths or loads than those that a system was built for.
    #[error(
        "a system answers for other rates of its own links only; build another one for other links, lengths or loads"
    )]
    OtherLinks,
    /// A mobility matrix that is not positive definite.
    #[error(
        "the mobility of the bodies is not positive definite (asymmetry {asymmetry:.1e}): the solves were not accurate \
         enough; ask for a smaller tolerance"
    )]
    NotPositiveDefinite {
        /// Largest difference to its transpose over its largest entry.
        asymmetry: f64,
    },
    /// An array whose length does not fit.
    #[error("{what}: expected {expected} entries, found {found}")]
    Length {
        /// What the array holds.
        what: &'static str,
        /// Wanted length.
        expected: usize,
        /// Length found.
        found: usize,
    },
    /// A number that is not finite.
    #[error("{what} is not finite")]
    NotFinite {
        /// What the number is.
        what: &'static str,
    },
    /// The assembled matrices do not fit together.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
}
