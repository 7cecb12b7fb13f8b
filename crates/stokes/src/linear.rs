//! Linear solvers for assembled systems, selected by [`Solver`].

use std::time::Instant;

use linalg::{
    BlockTriangular, KrylovParams, LinalgError, LinearOperator, Preconditioner, SaddleLdlt,
    Schwarz, SchwarzParams, SolveReport, WarmStart, fgmres, fgmres_columns, minres,
};
use rigid::Constrained;

use crate::StokesError;

/// Maximum number of iterations of additive Schwarz.
///
/// They grow with the number of subdomains, because there is no coarse level.
const MAX_SCHWARZ_ITERATIONS: usize = 1000;

/// Length of the Krylov basis of additive Schwarz: with 60 vectors between restarts the iteration
/// stalls, with 150 it converges. A vector takes 12 bytes per degree of freedom.
const SCHWARZ_RESTART: usize = 150;

/// Length of the Krylov basis of systems with convection, which stall between restarts where it
/// dominates: a steady flow at a Reynolds number of 10 takes 35 iterations, at 50 more than 100.
const UNSYMMETRIC_RESTART: usize = 200;

/// Maximum number of iterations of such systems.
const MAX_UNSYMMETRIC_ITERATIONS: usize = 600;

/// Maximum number of right-hand sides that are solved together, at about 24 vectors of memory each.
pub const MAX_COLUMNS: usize = 3;

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

/// Solutions of one system.
#[non_exhaustive]
pub struct Solutions {
    /// One solution per right-hand side, with its report.
    pub columns: Vec<(Vec<f64>, SolveReport)>,
    /// Seconds of setting up the solver.
    pub setup: f64,
    /// Seconds of all solves.
    pub solve: f64,
}

/// Solves an assembled system for several right-hand sides.
///
/// Krylov methods stop at the true relative residual `rtol`. The preconditioner of the block solver
/// is left in `block` for later solves.
pub fn solve_system(
    assembled: &Constrained,
    rhs: &[&[f64]],
    (solver, rtol): (Solver, f64),
    warm: &WarmStart,
    block: &mut Option<BlockTriangular>,
) -> Result<Solutions, StokesError> {
    let system = &assembled.system;
    let mut solutions = vec![vec![0.0; assembled.rhs.len()]; rhs.len()];
    let parameters = krylov(rtol, has_convection(assembled));
    let start = Instant::now();
    let mut columns: Vec<&mut [f64]> = solutions.iter_mut().map(Vec::as_mut_slice).collect();
    if solver != Solver::Direct {
        warm.guess_columns(system, rhs, &mut columns)?;
    }
    let clock = Instant::now();
    let setup;
    let reports = match solver {
        Solver::Block => {
            let preconditioner = block.insert(assembled.preconditioner()?);
            setup = clock.elapsed().as_secs_f64();
            solve_in_groups(system, preconditioner, rhs, &mut columns, &parameters)?
        }
        Solver::Direct => {
            let mut factor = SaddleLdlt::factor(system, &Default::default())?;
            setup = clock.elapsed().as_secs_f64();
            solve_each(rhs, &mut columns, |b, x| factor.solve(b, x))?
        }
        Solver::Schwarz {
            subdomains,
            overlap,
        } => {
            let mut preconditioner = Schwarz::new(system, &schwarz(subdomains, overlap))?;
            setup = clock.elapsed().as_secs_f64();
            let parameters = parameters
                .with_max_iterations(MAX_SCHWARZ_ITERATIONS)
                .with_restart(SCHWARZ_RESTART);
            // One at a time, because each Krylov basis is long.
            solve_each(rhs, &mut columns, |b, x| {
                fgmres(system, &mut preconditioner, b, x, &parameters)
            })?
        }
        Solver::Minres => {
            let mut preconditioner = assembled.symmetric_preconditioner()?;
            setup = clock.elapsed().as_secs_f64();
            solve_each(rhs, &mut columns, |b, x| {
                minres(system, &mut preconditioner, b, x, &parameters)
            })?
        }
    };
    Ok(Solutions {
        columns: solutions.into_iter().zip(reports).collect(),
        setup,
        solve: start.elapsed().as_secs_f64() - setup,
    })
}

/// Whether the stiffness has convection, which makes it unsymmetric.
pub(crate) fn has_convection(assembled: &Constrained) -> bool {
    !assembled.system.velocity_block().has_symmetric_stiffness()
}

/// Parameters of a Krylov method that stops at the true relative residual `rtol`.
fn krylov(rtol: f64, has_convection: bool) -> KrylovParams {
    let parameters = KrylovParams::default().with_rel_tol(rtol);
    match has_convection {
        true => parameters
            .with_restart(UNSYMMETRIC_RESTART)
            .with_max_iterations(MAX_UNSYMMETRIC_ITERATIONS),
        false => parameters,
    }
}

/// Preconditioner of a solver for an assembled system, or for operators near it.
pub fn preconditioner(
    assembled: &Constrained,
    solver: Solver,
) -> Result<Box<dyn Preconditioner>, StokesError> {
    let system = &assembled.system;
    Ok(match solver {
        Solver::Block => Box::new(assembled.preconditioner()?),
        Solver::Direct => Box::new(SaddleLdlt::factor(system, &Default::default())?),
        Solver::Schwarz {
            subdomains,
            overlap,
        } => Box::new(Schwarz::new(system, &schwarz(subdomains, overlap))?),
        Solver::Minres => Box::new(assembled.symmetric_preconditioner()?),
    })
}

/// Solves with an operator near a system, by the [`preconditioner`] of the system, from `solution`.
pub fn solve_near(
    (operator, has_convection): (&dyn LinearOperator, bool),
    preconditioner: &mut dyn Preconditioner,
    (rhs, solution): (&[f64], &mut [f64]),
    (solver, rtol): (Solver, f64),
) -> Result<SolveReport, LinalgError> {
    let parameters = krylov(rtol, has_convection);
    match solver {
        Solver::Minres => minres(operator, preconditioner, rhs, solution, &parameters),
        Solver::Schwarz { .. } => {
            let parameters = parameters
                .with_max_iterations(MAX_SCHWARZ_ITERATIONS)
                .with_restart(SCHWARZ_RESTART);
            fgmres(operator, preconditioner, rhs, solution, &parameters)
        }
        Solver::Block | Solver::Direct => {
            fgmres(operator, preconditioner, rhs, solution, &parameters)
        }
    }
}

fn schwarz(subdomains: usize, overlap: usize) -> SchwarzParams {
    SchwarzParams::default()
        .with_subdomains(subdomains)
        .with_overlap(overlap)
}

/// Solves for one right-hand side after the other.
fn solve_each(
    rhs: &[&[f64]],
    solutions: &mut [&mut [f64]],
    mut solve: impl FnMut(&[f64], &mut [f64]) -> Result<SolveReport, LinalgError>,
) -> Result<Vec<SolveReport>, LinalgError> {
    let pairs = rhs.iter().zip(solutions);
    pairs.map(|(rhs, solution)| solve(rhs, solution)).collect()
}

/// Solves for right-hand sides in groups of equal size, of at most [`MAX_COLUMNS`] each.
pub fn solve_in_groups(
    system: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    rhs: &[&[f64]],
    solutions: &mut [&mut [f64]],
    parameters: &KrylovParams,
) -> Result<Vec<SolveReport>, LinalgError> {
    let groups = rhs.len().div_ceil(MAX_COLUMNS).max(1);
    let size = rhs.len().div_ceil(groups).max(1);
    let mut reports = Vec::with_capacity(rhs.len());
    for (rhs, solutions) in rhs.chunks(size).zip(solutions.chunks_mut(size)) {
        let group = fgmres_columns(system, preconditioner, rhs, solutions, parameters)?;
        reports.extend(group);
    }
    Ok(reports)
}
