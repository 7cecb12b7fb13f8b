//! Errors of steps and steady states.

use linalg::LinalgError;
use rigid::RigidError;
use stokes::StokesError;

/// A step that cannot be taken, or a steady state that was not found, with what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InertiaError {
    /// A failed assembly or linear solve.
    #[error(transparent)]
    Stokes(#[from] StokesError),
    /// Bodies, joints or loads that do not fit.
    #[error(transparent)]
    Rigid(#[from] RigidError),
    /// A failed assembly.
    #[error(transparent)]
    Fem(#[from] fem::FemError),
    /// An unusable mesh.
    #[error(transparent)]
    Mesh(#[from] mesh::MeshError),
    /// A mesh that cannot follow its bodies.
    #[error(transparent)]
    Ale(#[from] ale::AleError),
    /// A number that is out of range.
    #[error("{what} is {value}; it must be {range}")]
    OutOfRange {
        /// Name of the number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Values that it may have.
        range: &'static str,
    },
    /// A list of the wrong length.
    #[error("expected {expected} {what}, found {found}")]
    Length {
        /// Name of the items that are counted.
        what: &'static str,
        /// Number required.
        expected: usize,
        /// Number found.
        found: usize,
    },
    /// An adaptive step that would have to be shorter than rounding allows.
    #[error(transparent)]
    StepTooShort(#[from] linalg::StepTooShort),
    /// A fixed-point iteration for a steady state that does not converge.
    #[error(
        "no steady state at density {density}: after {iterations} iterations the velocity still \
         changes by {change:.3e} of itself, {tolerance:.3e} was required; the flow may be unsteady \
         there (a sphere above a Reynolds number of 212): follow it in time, otherwise use smaller \
         elements or a smaller density"
    )]
    NotSteady {
        /// Density at which it failed.
        density: f64,
        /// Iterations made.
        iterations: usize,
        /// Relative change of the velocity in the last one.
        change: f64,
        /// Change required.
        tolerance: f64,
    },
    /// Equations of an iteration for a steady state that cannot be solved.
    #[error(
        "the equations of a steady state at density {density} cannot be solved ({source}): \
         convection is too strong for elements of this size; use smaller elements or a smaller \
         density, or follow the flow in time"
    )]
    Unresolved {
        /// Density at which it failed.
        density: f64,
        /// The failure of the solver.
        source: StokesError,
    },
    /// A steady state in the frame of a body that rotates.
    #[error(
        "body {body} turns at {spin:.3e} while the flow is required to be steady in its frame; \
         steady states are those of bodies that do not turn: integrate in time"
    )]
    Turning {
        /// Index of the body.
        body: usize,
        /// Largest component of its angular velocity.
        spin: f64,
    },
    /// A mesh that the caller's [`Meshes`](crate::Meshes) cannot supply.
    #[error(transparent)]
    Supplier(Box<dyn std::error::Error + Send + Sync>),
    /// A mesh that cannot follow the bodies, of a supplier without new ones.
    #[error(
        "at time {time} the mesh cannot follow the bodies any further, and there is no new one; \
         supply new meshes, or end before"
    )]
    NoMesh {
        /// The time.
        time: f64,
    },
    /// A point of a new mesh outside the old one.
    #[error(
        "the point ({:.6}, {:.6}, {:.6}) of the new mesh is outside the old one; both must fill \
         the same domain around the bodies at the same time", point[0], point[1], point[2]
    )]
    Outside {
        /// The point.
        point: [f64; 3],
    },
}

impl InertiaError {
    /// Whether a step in time fails that a shorter one may not: no mesh follows the bodies,
    /// Newton's method for a viscosity law fails, or the linear solver, whose matrix a shorter
    /// step makes more like a mass matrix.
    pub fn needs_shorter_step(&self) -> bool {
        match self {
            Self::NoMesh { .. } => true,
            Self::Stokes(error) => is_unsolved(error),
            _ => false,
        }
    }
}

/// Whether Newton's method or a linear solver fails, not the input.
pub(crate) fn is_unsolved(error: &StokesError) -> bool {
    let unsolved = |error: &LinalgError| {
        matches!(
            error,
            LinalgError::NotConverged { .. } | LinalgError::Stagnated { .. }
        )
    };
    let failure = linear_failure(error);
    matches!(error, StokesError::NewtonNotConverged { .. })
        || is_negative(failure)
        || failure.is_some_and(unsolved)
}

/// The error of the linear algebra behind a failed assembly or solve.
pub(crate) fn linear_failure(error: &StokesError) -> Option<&LinalgError> {
    match error {
        StokesError::Linalg(error) | StokesError::Rigid(RigidError::Linalg(error)) => Some(error),
        _ => None,
    }
}

/// Whether it is a matrix with a diagonal entry that is not positive.
pub(crate) fn is_negative(failure: Option<&LinalgError>) -> bool {
    matches!(failure, Some(LinalgError::NotPositive { .. }))
}

/// Refuses a list of the wrong length.
pub(crate) fn check_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), InertiaError> {
    match expected == found {
        true => Ok(()),
        false => Err(InertiaError::Length {
            what,
            expected,
            found,
        }),
    }
}
