//! Options of a solution: formulation, linear solver, tolerance, or an engine outside this crate.

use fem::SurplusSpace;
use rigid::{Drive, Eliminated, Formulation};

use crate::StokesError;
use crate::linear::Solver;
use crate::problem::Problem;
use crate::solution::Solution;

/// Constraint formulation, linear solver and tolerance of a solution.
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct Options {
    /// How the constraints of the joints enter the system.
    pub formulation: &'static dyn Formulation,
    /// How the linear system is solved.
    pub solver: Solver,
    /// True relative residual `|b - A x| / |b|` at which a Krylov method stops.
    pub rtol: f64,
    /// True relative residual to which the systems of error estimates are solved.
    ///
    /// `None` solves them as accurately as the uncertainty of the estimates requires, by a fixed
    /// number of iterations: corrections then differ by up to a percent between solvers.
    pub estimate_rtol: Option<f64>,
    /// What assembles and solves instead of this crate.
    pub engine: Option<&'static dyn Engine>,
}

/// Eliminated velocities (P-tilde) and the block solver, to a true residual of 1e-8.
impl Default for Options {
    fn default() -> Self {
        Self {
            formulation: &Eliminated,
            solver: Solver::Block,
            // Velocities then differ from those of a solve to 1e-12 by at most 5e-9
            // (docs/iterations.md).
            rtol: 1e-8,
            estimate_rtol: None,
            engine: None,
        }
    }
}

impl Options {
    /// The same with another formulation.
    #[must_use]
    pub fn with_formulation(self, formulation: &'static dyn Formulation) -> Self {
        Self {
            formulation,
            ..self
        }
    }

    /// The same with another solver.
    #[must_use]
    pub fn with_solver(self, solver: Solver) -> Self {
        Self { solver, ..self }
    }

    /// The same with an engine outside this crate.
    #[must_use]
    pub fn with_engine(self, engine: &'static dyn Engine) -> Self {
        Self {
            engine: Some(engine),
            ..self
        }
    }

    /// The same with error estimates whose systems are solved to this residual, for comparisons.
    #[must_use]
    pub fn with_estimate_rtol(self, rtol: f64) -> Self {
        Self {
            estimate_rtol: Some(rtol),
            ..self
        }
    }

    /// The same with another tolerance.
    #[must_use]
    pub fn with_rtol(self, rtol: f64) -> Self {
        Self { rtol, ..self }
    }
}

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
