//! The interface for solvers outside this crate.

use rigid::Drive;

use crate::{Options, Problem, Solution, StokesError};
use fem::SurplusSpace;

/// Assembles and solves problems in place of this crate, for example on many machines.
///
/// Selected by [`Options::with_engine`]. An engine is a unit struct or a static; what it needs at
/// run time, such as a communicator, it finds itself.
pub trait Engine: Sync {
    /// Solutions for drives that differ only in the rates of the joints.
    ///
    /// Errors are estimated if `surplus`, the hierarchical surplus space of the mesh, is given
    /// ([`Problem::estimate_part`]).
    ///
    /// # Errors
    /// Those of the problem; [`StokesError::Engine`] for all others.
    fn solve_all(
        &self,
        problem: &Problem,
        drives: &[Drive],
        options: &Options,
        surplus: Option<&SurplusSpace>,
    ) -> Result<Vec<Solution>, StokesError>;
}
