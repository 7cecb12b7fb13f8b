//! The engine by which models solve on all processes of a job.

use rigid::Drive;
use stokes::fem::SurplusSpace;
use stokes::{Engine, Options, Problem, Solution, Solver, StokesError};

use crate::gather::engine_error;
use crate::handles::Session;
use crate::solver::Method;
use crate::{Parameters, PetscError, solve};

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
        surplus: Option<&SurplusSpace>,
    ) -> Result<Vec<Solution>, StokesError> {
        let of_session = |session: &Session| {
            let method = match options.solver {
                Solver::Block => Method::Block,
                Solver::Direct => Method::Direct,
                other => return Err(PetscError::Unsupported { what: other.name() }),
            };
            let mut parameters = Parameters::default()
                .with_formulation(options.formulation)
                .with_method(method)
                .with_rtol(options.rtol);
            // Each process has the surplus space of its own part of the mesh.
            if surplus.is_some() {
                parameters = parameters.with_estimates(options.estimate_rtol);
            }
            let solved = solve(session, problem, drives, &parameters)?;
            Ok(solved.into_iter().map(|solved| solved.solution).collect())
        };
        Session::with_current(of_session).map_err(engine_error)
    }
}
