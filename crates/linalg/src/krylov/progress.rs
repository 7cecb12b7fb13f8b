//! Convergence control on the true residual, shared by all methods.

use super::report::{ERROR_OVER_RESIDUAL, KrylovParams, SolveReport};
use crate::vector::{norm, norm_over, subtract_from, weighted_norm};
use crate::{LinalgError, LinearOperator, SumOverProcesses};

/// Ratio of the true residuals after and before a cycle, in both norms, that means stagnation.
const STAGNATION_RATIO: f64 = 0.99;

/// Convergence state between two evaluations of the true residual.
pub(super) struct Progress<'a> {
    method: &'static str,
    params: &'a KrylovParams,
    b_norm: f64,
    weights: Option<&'a [f32]>,
    sum: Option<&'a SumOverProcesses<'a>>,
    /// `b` measured in the residual norm of the recurrence.
    b_weighted: f64,
    pub iterations: usize,
    history: Vec<f64>,
    /// At the last evaluation: the larger of both residuals, and that in the recurrence's norm.
    previous: [f64; 2],
    /// Residual that the recurrence must reach before the next evaluation.
    target: f64,
}

impl<'a> Progress<'a> {
    /// Measures residuals of the recurrence in the operator's weights.
    pub fn new(
        method: &'static str,
        operator: &'a dyn LinearOperator,
        params: &'a KrylovParams,
        b: &[f64],
    ) -> Self {
        let (weights, sum) = (operator.residual_weights(), operator.sum_over_processes());
        let b_norm = norm_over(sum, norm(b));
        Progress {
            b_weighted: weights.map_or(b_norm, |w| norm_over(sum, weighted_norm(w, b))),
            weights,
            sum,
            ..Self::unweighted(method, params, b_norm)
        }
    }

    /// Measures residuals of the recurrence in the Euclidean norm.
    pub fn unweighted(method: &'static str, params: &'a KrylovParams, b_norm: f64) -> Self {
        Progress {
            method,
            params,
            b_norm,
            weights: None,
            sum: None,
            b_weighted: b_norm,
            iterations: 0,
            history: Vec::with_capacity(params.max_iterations.min(1000) + 1),
            previous: [f64::INFINITY; 2],
            target: params.rel_tol,
        }
    }

    /// Writes `b - A x` into `r` and decides whether to stop.
    ///
    /// `Ok(Some(report))` if its norm is small enough, an error if further iterations are useless.
    pub fn check(
        &mut self,
        operator: &dyn LinearOperator,
        b: &[f64],
        x: &[f64],
        r: &mut [f64],
    ) -> Result<Option<SolveReport>, LinalgError> {
        operator.apply(x, r);
        self.check_product(b, r)
    }

    /// Decides as [`check`](Progress::check) does, with the product `A x` given in `r`.
    pub fn check_product(
        &mut self,
        b: &[f64],
        r: &mut [f64],
    ) -> Result<Option<SolveReport>, LinalgError> {
        subtract_from(b, r);
        let true_rel_residual = norm_over(self.sum, norm(r)) / self.b_norm;
        let weighted_rel_residual = self.weights.map_or(true_rel_residual, |w| {
            norm_over(self.sum, weighted_norm(w, r)) / self.b_weighted
        });
        let (method, iterations, target) = (self.method, self.iterations, self.params.rel_tol);
        if self.history.is_empty() {
            self.history.push(weighted_rel_residual);
        }
        if true_rel_residual.is_nan() {
            return Err(self.broken("the operator returned NaN"));
        }
        let estimate = self.error_estimate(weighted_rel_residual);
        let larger = true_rel_residual.max(estimate);
        if larger <= target {
            return Ok(Some(SolveReport {
                iterations,
                true_rel_residual,
                weighted_rel_residual,
                history: std::mem::take(&mut self.history),
                rhs_removed: 0.0,
            }));
        }
        if !self.may_iterate() {
            return Err(LinalgError::NotConverged {
                method,
                iterations,
                true_rel_residual: larger,
                weighted_rel_residual,
                target,
            });
        }
        let falls = |now: f64, before: f64| now <= STAGNATION_RATIO * before;
        if !falls(larger, self.previous[0]) && !falls(estimate, self.previous[1]) {
            return Err(LinalgError::Stagnated {
                method,
                iterations,
                true_rel_residual: larger,
                target,
            });
        }
        if self.previous[0].is_finite() || estimate <= target {
            // A start that is converged in one norm would end the first cycle after one iteration.
            // After a restart or a false convergence the recurrence may differ from the true
            // residual, hence the factor 0.5. The recurrence converges in one norm; if the residual
            // in the other norm is larger by some factor, the recurrence has to converge further by
            // this factor.
            self.target = 0.5 * target * estimate / larger;
        }
        self.previous = [larger, estimate];
        Ok(None)
    }

    /// Counts an iteration and returns whether the recurrence's residual norm is small enough.
    pub fn step(&mut self, residual_norm: f64) -> bool {
        self.iterations += 1;
        let residual = residual_norm / self.b_weighted;
        self.history.push(residual);
        self.error_estimate(residual) <= self.target
    }

    /// The number compared with the tolerance, from a relative residual in the recurrence's norm.
    fn error_estimate(&self, residual: f64) -> f64 {
        match self.weights {
            Some(_) => ERROR_OVER_RESIDUAL * residual,
            None => residual,
        }
    }

    /// Whether rounding a basis vector to f32 after a residual of `residual_norm` is harmless.
    ///
    /// The relative error of the vector, half of f32's epsilon, is multiplied by its coefficient.
    /// The coefficient is at most the residual over the smallest singular value of the
    /// preconditioned operator (0.1 and above in the bordered Stokes systems measured). A tenth of
    /// the target is reserved for this error.
    pub fn single_is_enough(&self, residual_norm: f64) -> bool {
        let amplified = 10.0 * residual_norm / self.b_weighted;
        0.5 * f64::from(f32::EPSILON) * amplified <= 0.1 * self.target
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
