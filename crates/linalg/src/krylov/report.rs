//! Parameters and reports of the Krylov methods.

use std::sync::Arc;

use super::null_vectors::NullVectors;
use crate::csr::check_finite;
use crate::vector::rhs_norm;
use crate::{LinalgError, LinearOperator, Preconditioner, PreconditionerKind};

/// Parameters of the Krylov methods.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct KrylovParams {
    /// Bound on the relative residual `||b - A x|| / ||b||`; 1e-8 by default.
    ///
    /// If the operator has weights, also on [`SolveReport::error_estimate`]. Always relative to
    /// `b`, so that a good initial guess saves iterations.
    pub rel_tol: f64,
    /// Bound on iterations, 300 by default; each one takes one product and one preconditioner
    /// application.
    pub max_iterations: usize,
    /// Basis vectors stored before a restart, 60 by default, of 8 to 12 bytes per dof each.
    ///
    /// Used by [`fgmres`](crate::fgmres) only.
    pub restart: usize,
    /// Null vectors of a singular operator; `None`, the default, for a regular one.
    pub null_vectors: Option<Arc<NullVectors>>,
}

impl Default for KrylovParams {
    fn default() -> Self {
        KrylovParams {
            // an error of 1e-8 is below the discretisation error of any affordable mesh
            rel_tol: 1e-8,
            // about ten times the iterations with a block preconditioner: more means that something
            // is wrong
            max_iterations: 300,
            restart: 60,
            null_vectors: None,
        }
    }
}

impl KrylovParams {
    /// Sets the null vectors of a singular operator.
    #[must_use]
    pub fn with_null_vectors(mut self, null_vectors: NullVectors) -> Self {
        self.null_vectors = Some(Arc::new(null_vectors));
        self
    }
}

setters!(KrylovParams {
    with_rel_tol(rel_tol: f64),
    with_max_iterations(max_iterations: usize),
    with_restart(restart: usize),
});

/// Ratio of the estimated relative error of the border dofs to the weighted residual.
///
/// Measured ratios were 0.2 to 2.3 for the velocity of a swimmer at tolerances from 1e-5 to 1e-9,
/// and less than 0.1 for spheres under forces, whose velocities are given by the energy of the
/// flow. With a factor of two the error was below each of these tolerances.
pub const ERROR_OVER_RESIDUAL: f64 = 2.0;

/// Result of a solve.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SolveReport {
    /// Number of products with the preconditioned operator.
    pub iterations: usize,
    /// `||b - A x|| / ||b||`, recomputed from the returned `x`; zero for `b = 0`.
    pub true_rel_residual: f64,
    /// Relative residual of the returned `x` in the norm of the operator's weights.
    ///
    /// The weights are those of
    /// [`LinearOperator::residual_weights`](crate::LinearOperator::residual_weights). Equal to
    /// `true_rel_residual` if the operator has none.
    pub weighted_rel_residual: f64,
    /// Relative residual of the recurrence before the first and after each iteration.
    pub history: Vec<f64>,
    /// Part of `b` outside the range of a singular operator, `||b - P b|| / ||b||`.
    ///
    /// Zero unless [`KrylovParams::null_vectors`] is given. The residuals are then those of the
    /// projected right-hand side, relative to `||P b||`.
    pub rhs_removed: f64,
}

impl SolveReport {
    /// Estimated relative error of the border dofs: twice the weighted residual.
    ///
    /// In Stokes flow, where the border contains the velocities of rigid bodies, the error was 0.2
    /// to 2.3 weighted residuals for swimmers and less than 0.1 for spheres under forces.
    pub fn error_estimate(&self) -> f64 {
        ERROR_OVER_RESIDUAL * self.weighted_rel_residual
    }

    /// The report for `b = 0`; overwrites `x` with the zero solution.
    pub(super) fn zero(x: &mut [f64]) -> Self {
        x.fill(0.0);
        SolveReport {
            history: vec![0.0],
            ..SolveReport::none()
        }
    }

    /// The report of a solve that has not begun.
    pub(super) fn none() -> Self {
        SolveReport {
            iterations: 0,
            true_rel_residual: 0.0,
            weighted_rel_residual: 0.0,
            history: Vec::new(),
            rhs_removed: 0.0,
        }
    }
}

/// Refuses an operator or a preconditioner that a symmetric method cannot use.
///
/// The operator must be symmetric, the preconditioner symmetric positive definite.
pub(super) fn check_symmetric(
    method: &'static str,
    operator: &dyn LinearOperator,
    preconditioner: &dyn Preconditioner,
) -> Result<(), LinalgError> {
    if !operator.is_symmetric() {
        return Err(LinalgError::NotSymmetric { method });
    }
    if operator.sum_over_processes().is_some() {
        return Err(LinalgError::SeveralProcesses { method });
    }
    let (needed, found) = (PreconditionerKind::PositiveDefinite, preconditioner.kind());
    if found > needed {
        return Err(LinalgError::UnsuitablePreconditioner {
            method,
            needed,
            found,
        });
    }
    Ok(())
}

/// Checks sizes, finiteness and parameters; returns `Some(||b||)` unless `b` is zero.
pub(super) fn check_start(
    operator: &dyn LinearOperator,
    preconditioner: &dyn Preconditioner,
    b: &[f64],
    x: &[f64],
    params: &KrylovParams,
) -> Result<Option<f64>, LinalgError> {
    let n = operator.rows();
    let size = |what, found: usize| crate::csr::check_shape(what, (found, 1), (n, 1));
    size("operator (columns)", operator.cols())?;
    size("preconditioner", preconditioner.size())?;
    size("right-hand side", b.len())?;
    size("solution vector", x.len())?;
    check_finite("right-hand side", b)?;
    check_finite("initial guess", x)?;
    if !(params.rel_tol > 0.0 && params.rel_tol < 1.0) {
        return Err(LinalgError::Parameter {
            name: "rel_tol",
            value: params.rel_tol,
            range: "between 0 and 1",
        });
    }
    if params.restart == 0 {
        return Err(LinalgError::Parameter {
            name: "restart",
            value: 0.0,
            range: "at least 1",
        });
    }
    rhs_norm(b, operator.sum_over_processes())
}
