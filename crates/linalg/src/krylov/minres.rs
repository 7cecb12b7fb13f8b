//! The preconditioned minimal-residual method.

use super::complement;
use super::progress::Progress;
use super::report::{KrylovParams, SolveReport};
use crate::vector::{axpy, dot, norm, scale};
use crate::{LinalgError, LinearOperator, Preconditioner};

const METHOD: &str = "MINRES";

/// Solves `A x = b` for a symmetric, possibly indefinite `A` by MINRES, starting from `x`.
///
/// Three-term recurrences need seven vectors for any number of iterations, where
/// [`fgmres`](crate::fgmres) stores two per iteration. The preconditioner must be symmetric
/// positive definite, as [`BlockDiagonal`](crate::BlockDiagonal) is. The method minimises the
/// residual in the norm of the preconditioner. A second recurrence carries the residual itself,
/// `r_k = s^2 r_{k-1} + c phi_k v_{k+1}`, and the iteration stops on the *true*
/// `||b - A x|| / ||b||`, recomputed as in [`fgmres`](crate::fgmres). References: Paige, Saunders,
/// SIAM J. Numer. Anal. 12 (1975); Elman, Silvester, Wathen, Finite Elements and Fast Iterative
/// Solvers, algorithm 4.1.
///
/// # Errors
/// [`LinalgError::NotSymmetric`], [`LinalgError::UnsuitablePreconditioner`] unless it is positive
/// definite, [`LinalgError::Breakdown`] if the iteration finds that it is not; otherwise those of
/// [`fgmres`](crate::fgmres).
///
/// ```
/// use linalg::{Bordered, Csr, Identity, KrylovParams, minres};
/// // x = 0 by a Lagrange multiplier l: [I3 C; C^T 0] with C = e_x is indefinite
/// let (k, c) = (Csr::eye(1), Csr::new((3, 1), vec![0, 1, 1, 1], vec![0], vec![1.0]));
/// let a = Bordered::new(k, c, None, nalgebra::DMatrix::zeros(1, 1))?;
/// let mut x = [0.0; 4];
/// let (b, params) = ([5.0, 6.0, 7.0, 0.0], KrylovParams::default());
/// let report = minres(&a, &mut Identity(4), &b, &mut x, &params)?;
/// assert!(report.iterations <= 3); // as many as there are distinct eigenvalues
/// assert!((x[0] - 0.0).abs() < 1e-7 && (x[1] - 6.0).abs() < 1e-7 && (x[3] - 5.0).abs() < 1e-7);
/// # Ok::<(), linalg::LinalgError>(())
/// ```
pub fn minres(
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
    let [mut r, mut v, mut z, mut v_old, mut w, mut w_old, mut q] =
        [(); 7].map(|()| vec![0.0; b.len()]);
    loop {
        if let Some(report) = progress.check(operator, b, x, &mut r)? {
            return Ok(report);
        }
        v.copy_from_slice(&r);
        // Lanczos: A Z = V T with V^T Z = I, Z = N V, T tridiagonal with `alpha` between two `beta`
        let mut phi = lanczos_norm(preconditioner, &v, &mut z, &progress)?;
        scale(phi.recip(), &mut v);
        scale(phi.recip(), &mut z);
        let mut beta = 0.0;
        for vector in [&mut v_old, &mut w, &mut w_old] {
            vector.fill(0.0);
        }
        // the last two Givens rotations (c, s), which make T triangular
        let (mut rotation, mut rotation_old) = ((1.0, 0.0), (1.0, 0.0));
        while progress.may_iterate() {
            operator.apply(&z, &mut q);
            let alpha = dot(&q, &z);
            axpy(-alpha, &v, &mut q);
            axpy(-beta, &v_old, &mut q);

            // column of T: (beta, alpha, beta_next); the last two rotations, then a new one
            let above = rotation_old.1 * beta;
            let middle = rotation_old.0 * beta;
            let (c, s) = rotation;
            let (upper, diagonal) = (c * middle + s * alpha, c * alpha - s * middle);
            std::mem::swap(&mut v_old, &mut v);
            std::mem::swap(&mut v, &mut q);
            // w_next = (z - upper w - above w_old) / pivot, before z is overwritten
            scale(-above, &mut w_old);
            axpy(-upper, &w, &mut w_old);
            axpy(1.0, &z, &mut w_old);
            beta = lanczos_norm(preconditioner, &v, &mut z, &progress)?;
            let pivot = diagonal.hypot(beta);
            // the operator is singular on the Krylov space: x cannot be improved
            if pivot <= f64::EPSILON * alpha.abs().max(upper.abs()) {
                progress.step(norm(&r));
                break;
            }
            let (c, s) = (diagonal / pivot, beta / pivot);
            scale(pivot.recip(), &mut w_old);
            std::mem::swap(&mut w, &mut w_old);
            axpy(c * phi, &w, x);
            phi *= -s;
            (rotation_old, rotation) = (rotation, (c, s));
            // an invariant subspace contains the solution
            if beta <= f64::EPSILON * pivot {
                progress.step(0.0);
                break;
            }
            scale(beta.recip(), &mut v);
            scale(beta.recip(), &mut z);
            scale(s * s, &mut r);
            axpy(c * phi, &v, &mut r);
            if progress.step(norm(&r)) {
                break;
            }
        }
    }
}

/// `z <- N v`, and `sqrt(v . z)`.
fn lanczos_norm(
    preconditioner: &mut dyn Preconditioner,
    v: &[f64],
    z: &mut [f64],
    progress: &Progress,
) -> Result<f64, LinalgError> {
    preconditioner.apply(v, z);
    let square = dot(v, z);
    if square.is_nan() {
        return Err(progress.broken("the operator or the preconditioner returned NaN"));
    }
    if square < 0.0 {
        return Err(progress.broken("the preconditioner is not positive definite"));
    }
    Ok(square.sqrt())
}
