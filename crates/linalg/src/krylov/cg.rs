//! The preconditioned conjugate-gradient method.

use super::complement;
use super::progress::Progress;
use super::report::{KrylovParams, SolveReport};
use crate::vector::{axpy, dot, norm, xpby};
use crate::{LinalgError, LinearOperator, Preconditioner};

const METHOD: &str = "CG";

/// Solves `A x = b` for a symmetric positive definite `A` by conjugate gradients from `x`.
///
/// A semidefinite `A` needs its null vectors, [`KrylovParams::with_null_vectors`]. Three right-hand
/// sides of one scalar matrix are one system, `K (x) I3`
/// ([`Bordered::scalar`](crate::Bordered::scalar)): one pass over the matrix serves all three.
///
/// Stops on the *true* `||b - A x|| / ||b||`, as [`fgmres`](crate::fgmres) does. The search
/// directions are the flexible (Polak-Ribiere) ones, which tolerate the rounding errors of a
/// preconditioner in f32 (Notay 2000).
///
/// # Errors
/// [`LinalgError::NotSymmetric`], [`LinalgError::UnsuitablePreconditioner`] unless it is positive
/// definite, [`LinalgError::Breakdown`] if the iteration finds that `A` is not; otherwise those of
/// [`fgmres`](crate::fgmres).
pub fn cg(
    operator: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    b: &[f64],
    x: &mut [f64],
    params: &KrylovParams,
) -> Result<SolveReport, LinalgError> {
    complement::solve_symmetric(METHOD, operator, preconditioner, b, x, params, iterate)
}

fn iterate(
    operator: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    b: &[f64],
    x: &mut [f64],
    mut progress: Progress,
) -> Result<SolveReport, LinalgError> {
    let [mut r, mut z, mut p, mut q] = [(); 4].map(|()| vec![0.0; b.len()]);
    loop {
        if let Some(report) = progress.check(operator, b, x, &mut r)? {
            return Ok(report);
        }
        preconditioner.apply(&r, &mut z);
        p.copy_from_slice(&z);
        let mut rz = dot(&r, &z);
        while progress.may_iterate() {
            operator.apply(&p, &mut q);
            let curvature = dot(&p, &q);
            if !(curvature > 0.0 && rz > 0.0) {
                let cause = if curvature.is_nan() || rz.is_nan() {
                    "the operator or the preconditioner returned NaN"
                } else {
                    "the operator or the preconditioner is not positive definite; indefinite \
                     operators, such as those of saddle points, need minres or fgmres"
                };
                return Err(progress.broken(cause));
            }
            let alpha = rz / curvature;
            axpy(alpha, &p, x);
            axpy(-alpha, &q, &mut r);
            if progress.step(norm(&r)) {
                break;
            }
            // zero for an exactly symmetric preconditioner
            let stale = dot(&r, &z);
            preconditioner.apply(&r, &mut z);
            let next = dot(&r, &z);
            xpby(&z, (next - stale) / rz, &mut p);
            rz = next;
        }
    }
}
