//! Solver options from the options of a scene.

use rigid::{DirectRows, Eliminated, Formulation, Lagrange};
use scene::{FemOptions, FormulationKind, SolverKind};
use stokes::{Options, Solver};

/// Formulation, solver and tolerance of a scene.
pub fn options(fem: &FemOptions) -> Options {
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
    Options::default()
        .with_formulation(formulation)
        .with_solver(solver)
        .with_rtol(fem.rtol)
}
