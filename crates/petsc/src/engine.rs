//! The engine by which models solve on all processes of a job.

use rigid::Drive;
use stokes::{Engine, Options, Problem, Solution, Solver, StokesError};

use crate::handles::Session;
use crate::solver::Method;
use crate::{PetscError, solve};

/// Solves on all processes of the [`Session`] that the calling thread has started.
///
/// Every process makes the same calls with the same problems; answers are the same on all, so that
/// programs take the same decisions everywhere.
#[derive(Clone, Copy, Debug, Default)]
pub struct PetscEngine;

impl Engine for PetscEngine {
    fn solve_all(
        &self,
        problem: &Problem,
        drives: &[Drive],
        options: &Options,
    ) -> Result<Vec<Solution>, StokesError> {
        let of_session = |session: &Session| {
            let method = match options.solver {
                Solver::Block => Method::Block,
                Solver::Direct => Method::Direct,
                other => return Err(PetscError::Unsupported { what: other.name() }),
            };
            let one = |drive: &Drive| {
                let (formulation, rtol) = (options.formulation, options.rtol);
                let solved = solve(session, problem, drive, formulation, method, rtol)?;
                Ok(solved.solution)
            };
            drives.iter().map(one).collect()
        };
        Session::with_current(of_session).map_err(|error| StokesError::Engine(error.into()))
    }
}
