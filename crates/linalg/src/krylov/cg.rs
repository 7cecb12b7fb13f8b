//! Preconditioned conjugate gradients.

use super::report::{KrylovParams, SolveReport, check_start};
use crate::vector::{axpy, dot, norm, subtract_from, xpby};
use crate::{LinalgError, LinearOperator, Preconditioner, PreconditionerKind};

const METHOD: &str = "CG";

/// Solves `A x = b` for a symmetric positive definite `A`, starting from `x`.
///
/// Three right-hand sides of one scalar matrix are one system, `K (x) I3` ([`Bordered::scalar`](crate::Bordered::scalar)): a
/// matrix pass serves all three. Stops on the *true* `||b - A x|| / ||b||`, as [`fgmres`](crate::fgmres); the step
/// is the flexible (Polak-Ribiere) one, which forgives the rounding of an f32 preconditioner (Notay 2000).
///
/// # Errors
/// [`LinalgError::UnsuitablePreconditioner`] unless it is positive definite; [`LinalgError::Breakdown`] when `A` shows not to be;
/// otherwise those of [`fgmres`](crate::fgmres).
pub fn cg(
    operator: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    b: &[f64],
    x: &mut [f64],
    params: &KrylovParams,
) -> Result<SolveReport, LinalgError> {
    let needed = PreconditionerKind::PositiveDefinite;
    if preconditioner.kind() > needed {
        return Err(LinalgError::UnsuitablePreconditioner {
            method: METHOD,
            needed,
            found: preconditioner.kind(),
        });
    }
    let Some(b_norm) = check_start(operator, preconditioner, b, x, params)? else {
        x.fill(0.0);
        return Ok(SolveReport {
            iterations: 0,
            true_rel_residual: 0.0,
            history: vec![0.0],
        });
    };
    let n = b.len();
    let [mut r, mut z, mut p, mut q] = [(); 4].map(|()| vec![0.0; n]);
    let mut iterations = 0;
    let mut history = Vec::new();
    let mut previous = f64::INFINITY;
    loop {
        operator.apply(x, &mut r);
        subtract_from(b, &mut r);
        let true_rel_residual = norm(&r) / b_norm;
        if history.is_empty() {
            history.push(true_rel_residual);
        }
        if true_rel_residual.is_nan() {
            return Err(broken(iterations, "the operator returned NaN"));
        }
        if true_rel_residual <= params.rel_tol {
            return Ok(SolveReport {
                iterations,
                true_rel_residual,
                history,
            });
        }
        if iterations >= params.max_iterations {
            return Err(LinalgError::NotConverged {
                method: METHOD,
                iterations,
                true_rel_residual,
                target: params.rel_tol,
            });
        }
        // the recurrence said converged, the truth is no better than the last time it did
        if true_rel_residual >= previous {
            return Err(LinalgError::Stagnated {
                method: METHOD,
                iterations,
                true_rel_residual,
                target: params.rel_tol,
            });
        }
        previous = true_rel_residual;
        preconditioner.apply(&r, &mut z);
        p.copy_from_slice(&z);
        let mut rz = dot(&r, &z);
        while iterations < params.max_iterations {
            operator.apply(&p, &mut q);
            let curvature = dot(&p, &q);
            if !(curvature > 0.0 && rz > 0.0) {
                let cause = if curvature.is_nan() || rz.is_nan() {
                    "the operator or the preconditioner returned NaN"
                } else {
                    "the operator or the preconditioner is not positive definite"
                };
                return Err(broken(iterations, cause));
            }
            let alpha = rz / curvature;
            axpy(alpha, &p, x);
            axpy(-alpha, &q, &mut r);
            iterations += 1;
            let residual = norm(&r) / b_norm;
            history.push(residual);
            if residual <= params.rel_tol {
                break;
            }
            // r . z_old is what an exactly symmetric preconditioner would make zero
            let stale = dot(&r, &z);
            preconditioner.apply(&r, &mut z);
            let next = dot(&r, &z);
            xpby(&z, (next - stale) / rz, &mut p);
            rz = next;
        }
    }
}

fn broken(iteration: usize, cause: &'static str) -> LinalgError {
    LinalgError::Breakdown {
        method: METHOD,
        iteration,
        cause,
    }
}
