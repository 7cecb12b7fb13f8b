//! Solver options from the options of a scene, and solvers outside this workspace.

use rigid::{DirectRows, Eliminated, Formulation, Lagrange};
use scene::{FormulationKind, SolverKind};
use stokes::{Engine, Options, Solver};

use super::FemModel;

impl FemModel {
    /// The same model with systems solved by `engine`.
    ///
    /// Resistance matrices are still computed by `stokes`.
    #[must_use]
    pub fn with_engine(self, engine: &'static dyn Engine) -> Self {
        Self {
            engine: Some(engine),
            ..self
        }
    }

    /// Formulation, solver, tolerance and engine.
    pub(super) fn solver_options(&self) -> Options {
        let fem = &self.options;
        let formulation: &'static dyn Formulation = match fem.formulation {
            FormulationKind::PTilde => &Eliminated,
            FormulationKind::Lagrange => &Lagrange,
            FormulationKind::DirectRow => &DirectRows,
        };
        let solver = match fem.solver {
            SolverKind::Block => Solver::Block,
            SolverKind::Direct => Solver::Direct,
            SolverKind::Schwarz => Solver::Schwarz {
                subdomains: fem.subdomains as usize,
                overlap: fem.overlap as usize,
            },
            SolverKind::Minres => Solver::Minres,
        };
        let mut options = Options::default()
            .with_formulation(formulation)
            .with_solver(solver)
            .with_rtol(fem.rtol);
        options.engine = self.engine;
        options
    }
}
