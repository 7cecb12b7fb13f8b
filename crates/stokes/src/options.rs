//! Formulation, linear solver and tolerance.

use rigid::{Eliminated, Formulation};

use crate::Engine;

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

/// A solver of the linear system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Solver {
    /// FGMRES with the block-triangular multigrid preconditioner: the fastest, for all
    /// formulations.
    Block,
    /// Direct factorisation with iterative refinement: for small systems and comparisons.
    Direct,
    /// FGMRES with additive Schwarz: for comparisons.
    Schwarz {
        /// Number of subdomains.
        subdomains: usize,
        /// Layers of overlap between them.
        overlap: usize,
    },
    /// MINRES with the block-diagonal preconditioner: the least memory, for symmetric formulations.
    Minres,
}

impl Solver {
    /// Name for reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Block => "block",
            Self::Direct => "direct",
            Self::Schwarz { .. } => "schwarz",
            Self::Minres => "minres",
        }
    }
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
