//! The book-keeping of true residuals that all methods share.

use super::report::{KrylovParams, SolveReport};
use crate::vector::{norm, subtract_from};
use crate::{LinalgError, LinearOperator};

/// A cycle that leaves more than this part of the true residual has stagnated.
const STAGNATION: f64 = 0.99;

/// The state of an iteration between its looks at the true residual.
pub(super) struct Progress<'a> {
    method: &'static str,
    params: &'a KrylovParams,
    b_norm: f64,
    pub iterations: usize,
    history: Vec<f64>,
    /// The true relative residual at the last look.
    previous: f64,
    /// What a recurrence has to reach before the next look.
    target: f64,
}

impl<'a> Progress<'a> {
    pub fn new(method: &'static str, params: &'a KrylovParams, b_norm: f64) -> Self {
        Progress {
            method,
            params,
            b_norm,
            iterations: 0,
            history: Vec::with_capacity(params.max_iterations.min(1000) + 1),
            previous: f64::INFINITY,
            target: params.rel_tol,
        }
    }

    /// Writes `b - A x` into `r`; `Ok(Some(report))` when its norm is small enough, an error when there is no point in going on.
    pub fn look(
        &mut self,
        operator: &dyn LinearOperator,
        b: &[f64],
        x: &[f64],
        r: &mut [f64],
    ) -> Result<Option<SolveReport>, LinalgError> {
        operator.apply(x, r);
        subtract_from(b, r);
        let true_rel_residual = norm(r) / self.b_norm;
        let (method, iterations, target) = (self.method, self.iterations, self.params.rel_tol);
        if self.history.is_empty() {
            self.history.push(true_rel_residual);
        }
        if true_rel_residual.is_nan() {
            return Err(self.broken("the operator returned NaN"));
        }
        if true_rel_residual <= target {
            return Ok(Some(SolveReport {
                iterations,
                true_rel_residual,
                history: std::mem::take(&mut self.history),
            }));
        }
        if !self.may_iterate() {
            return Err(LinalgError::NotConverged {
                method,
                iterations,
                true_rel_residual,
                target,
            });
        }
        if true_rel_residual > STAGNATION * self.previous {
            return Err(LinalgError::Stagnated {
                method,
                iterations,
                true_rel_residual,
                target,
            });
        }
        if self.previous.is_finite() {
            // after a restart or a false convergence: leave room for the recurrence to differ from the truth
            self.target = 0.5 * target;
        }
        self.previous = true_rel_residual;
        Ok(None)
    }

    /// Counts an iteration with the residual norm its recurrence found; whether that is small enough.
    pub fn step(&mut self, residual_norm: f64) -> bool {
        self.iterations += 1;
        let residual = residual_norm / self.b_norm;
        self.history.push(residual);
        residual <= self.target
    }

    pub fn may_iterate(&self) -> bool {
        self.iterations < self.params.max_iterations
    }

    pub fn broken(&self, cause: &'static str) -> LinalgError {
        LinalgError::Breakdown {
            method: self.method,
            iteration: self.iterations,
            cause,
        }
    }
}
