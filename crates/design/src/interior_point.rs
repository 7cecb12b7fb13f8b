//! A primal-dual interior-point method for one condition, bounds on linear functions, and
//! inequalities.
//!
//! ```text
//! minimise f(x)   with h(x) = 0,   lower <= Φ x + offset <= upper,   g(x) >= 0
//! ```
//!
//! The bounds and inequalities hold strictly in every iterate, so that functions are never
//! evaluated outside of them. Newton's method on the perturbed optimality conditions (Nocedal &
//! Wright 2006, chapter 19) with damped BFGS updates of the Hessian of the Lagrangian (Powell
//! 1978), the fraction-to-boundary rule with 0.995, and a line search on the exact penalty
//! function.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::evaluation::{Bounds, Evaluation, Multipliers, Problem, Slacks};

/// A minimum.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// The point.
    pub x: DVector<f64>,
    /// The function there.
    pub cost: f64,
    /// Number of iterations.
    pub iterations: usize,
    /// Violation of the condition.
    pub violation: f64,
    /// Predicted further decrease of the cost, including that by the distance from the bounds.
    pub decrease: f64,
    /// Whether some bound is active.
    pub at_bounds: bool,
}

/// Distance from a bound, relative to the range, below which the bound counts as active.
const ACTIVE_DISTANCE: f64 = 1e-3;
/// Smallest factor on a step.
const MIN_STEP_FACTOR: f64 = 1e-10;
/// Part of the predicted decrease that a step must achieve.
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Minimises from a point strictly inside the bounds.
///
/// Ends when the predicted decrease and the violation of the condition are below `tolerance`, when
/// no step decreases the penalty function any more, or after `max_iterations`. None if the
/// functions are not defined at the start, or if it is outside the
/// bounds.
pub fn minimise(
    problem: &dyn Problem,
    bounds: &Bounds,
    start: DVector<f64>,
    tolerance: f64,
    max_iterations: usize,
) -> Option<Minimum> {
    let mut x = start;
    let mut here = problem.evaluate(&x)?;
    let bounds = &here.with_inequalities(bounds);
    let mut slacks = Slacks::new(&here.rows(problem, &x), bounds)?;
    let mut hessian = problem.first_hessian(&x)?;
    let rows = slacks.lower.len() as f64;
    let smallest_barrier = tolerance / (2.0 * rows);
    let mut barrier = 0.1 / rows;
    let mut multipliers = slacks.multipliers(barrier);
    let mut penalty = 0.0_f64;
    let mut has_restarted = false;
    let (mut iterations, mut decrease) = (0, f64::INFINITY);
    while iterations < max_iterations {
        iterations += 1;
        let Some(step) = Step::new(problem, &here, &slacks, &multipliers, &hessian, barrier) else {
            // Rounding has made the matrix indefinite.
            if has_restarted {
                break;
            }
            (hessian, has_restarted) = (problem.first_hessian(&x)?, true);
            continue;
        };
        let violation = here.violation();
        decrease = step.decrement + 2.0 * rows * barrier;
        if step.decrement <= 0.1 * rows * barrier.max(smallest_barrier) && violation <= tolerance {
            if barrier <= smallest_barrier {
                break;
            }
            barrier = (0.1 * barrier).max(smallest_barrier);
            continue;
        }
        // It may decrease again: the first multipliers far from the condition are large.
        penalty = (1.5 * step.multiplier.abs()).max(0.5 * penalty);
        let search = LineSearch {
            problem,
            bounds,
            barrier,
            penalty,
            step: &step,
        };
        let accepted = search.accepted(&x, &here, &slacks);
        let Some((trial, evaluation, new)) = accepted else {
            if has_restarted {
                break;
            }
            (hessian, has_restarted) = (problem.first_hessian(&x)?, true);
            continue;
        };
        has_restarted = false;
        multipliers = multipliers.moved(&slacks, &new, &step.slack_change, barrier);
        let lagrangian = |e: &Evaluation| e.lagrangian_gradient(step.multiplier, &multipliers);
        let difference = lagrangian(&evaluation) - lagrangian(&here);
        update(&mut hessian, &(&trial - &x), &difference);
        (x, here, slacks) = (trial, evaluation, new);
    }
    Some(Minimum {
        violation: here.violation(),
        cost: here.cost,
        at_bounds: slacks.smallest_share() < ACTIVE_DISTANCE,
        x,
        iterations,
        decrease,
    })
}

/// The search along a step for a point at which the penalty function decreases.
struct LineSearch<'a> {
    problem: &'a dyn Problem,
    bounds: &'a Bounds,
    barrier: f64,
    penalty: f64,
    step: &'a Step,
}

impl LineSearch<'_> {
    fn merit(&self, e: &Evaluation, s: &Slacks) -> f64 {
        e.cost - self.barrier * s.logarithms() + self.penalty * e.violation()
    }

    /// The first point that is accepted; none if steps become too short.
    fn accepted(
        &self,
        x: &DVector<f64>,
        here: &Evaluation,
        slacks: &Slacks,
    ) -> Option<(DVector<f64>, Evaluation, Slacks)> {
        let violation = here.violation();
        let slope = self.step.slope - self.penalty * violation;
        let before = self.merit(here, slacks);
        let mut factor = slacks.longest(&self.step.slack_change);
        let mut correction = None;
        loop {
            let mut trial = x + factor * &self.step.change;
            if let Some(correction) = &correction {
                trial += correction;
            }
            let found = self.problem.evaluate(&trial);
            let slacks = |e: &Evaluation| Slacks::new(&e.rows(self.problem, &trial), self.bounds);
            if let Some((new, evaluation)) = found.and_then(|e| Some((slacks(&e)?, e))) {
                // Rounding of the merit function counts as a decrease.
                let rounding = 1e-14 * before.abs().max(1.0);
                let allowed = before + SUFFICIENT_DECREASE * factor * slope + rounding;
                if self.merit(&evaluation, &new) <= allowed {
                    return Some((trial, evaluation, new));
                }
                // A second-order correction of the condition, once per step.
                if correction.is_none() && factor == 1.0 && evaluation.violation() >= violation {
                    correction = Some(self.step.correction(&evaluation));
                    continue;
                }
            }
            correction = Some(DVector::zeros(x.len()));
            factor *= 0.5;
            if factor < MIN_STEP_FACTOR {
                return None;
            }
        }
    }
}

/// A step of Newton's method.
struct Step {
    change: DVector<f64>,
    /// Change of the rows.
    slack_change: DVector<f64>,
    /// Multiplier of the condition.
    multiplier: f64,
    /// Derivative of the cost with its barrier along the step.
    slope: f64,
    /// Half of the square of the step in the norm of the matrix.
    decrement: f64,
    /// `H^-1 J^T / (J H^-1 J^T)`.
    restoring: Option<DVector<f64>>,
}

impl Step {
    fn new(
        problem: &dyn Problem,
        here: &Evaluation,
        slacks: &Slacks,
        multipliers: &Multipliers,
        hessian: &DMatrix<f64>,
        barrier: f64,
    ) -> Option<Self> {
        let weights = multipliers.lower.component_div(&slacks.lower)
            + multipliers.upper.component_div(&slacks.upper);
        let matrix = hessian + here.weighted_product(problem, &weights);
        let pushes = slacks.upper.map(|s| barrier / s) - slacks.lower.map(|s| barrier / s);
        let gradient = &here.gradient + here.transposed(problem, &pushes);
        let factor: Cholesky<f64, Dyn> = matrix.clone().cholesky()?;
        let descent = factor.solve(&gradient);
        let (change, multiplier, restoring) = match &here.condition {
            None => (-descent, 0.0, None),
            Some((value, slope)) => {
                let response = factor.solve(slope);
                let stiffness = slope.dot(&response);
                let multiplier = (value - slope.dot(&descent)) / stiffness;
                let restoring = &response / stiffness;
                (
                    -descent - multiplier * response,
                    multiplier,
                    Some(restoring),
                )
            }
        };
        let is_finite = change.iter().all(|c| c.is_finite());
        is_finite.then(|| Self {
            slack_change: here.change_of_rows(problem, &change),
            slope: gradient.dot(&change),
            decrement: 0.5 * change.dot(&(&matrix * &change)),
            change,
            multiplier,
            restoring,
        })
    }

    /// A small change that corrects the condition at the end of the step.
    fn correction(&self, end: &Evaluation) -> DVector<f64> {
        match (&self.restoring, &end.condition) {
            (Some(restoring), Some((value, _))) => -*value * restoring,
            _ => DVector::zeros(self.change.len()),
        }
    }
}

/// Damped BFGS update: the matrix stays positive definite.
fn update(hessian: &mut DMatrix<f64>, step: &DVector<f64>, difference: &DVector<f64>) {
    // Powell's bound on the change of the curvature along the step.
    const SMALLEST_CURVATURE: f64 = 0.2;
    let image = &*hessian * step;
    let (curvature, product) = (step.dot(&image), step.dot(difference));
    if curvature.is_nan() || curvature <= 0.0 {
        return;
    }
    let share = match product < SMALLEST_CURVATURE * curvature {
        true => (1.0 - SMALLEST_CURVATURE) * curvature / (curvature - product),
        false => 1.0,
    };
    let damped = share * difference + (1.0 - share) * &image;
    let along = step.dot(&damped);
    hessian.ger(-1.0 / curvature, &image, &image, 1.0);
    hessian.ger(1.0 / along, &damped, &damped, 1.0);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `minimise (x - 3)^2 + 2 (y + 1)^2 + x y` with `x^2 + y^2 = 2` or without, in a box.
    struct Quadratic {
        has_condition: bool,
    }

    impl Problem for Quadratic {
        fn evaluate(&self, p: &DVector<f64>) -> Option<Evaluation> {
            let (x, y) = (p[0], p[1]);
            let condition = (
                x * x + y * y - 2.0,
                DVector::from_vec(vec![2.0 * x, 2.0 * y]),
            );
            Some(Evaluation {
                cost: (x - 3.0).powi(2) + 2.0 * (y + 1.0).powi(2) + x * y,
                gradient: DVector::from_vec(vec![2.0 * (x - 3.0) + y, 4.0 * (y + 1.0) + x]),
                condition: self.has_condition.then_some(condition),
                positive: None,
            })
        }

        fn rows(&self, x: &DVector<f64>) -> DVector<f64> {
            x.clone()
        }

        fn weighted_product(&self, weights: &DVector<f64>) -> DMatrix<f64> {
            DMatrix::from_diagonal(weights)
        }

        fn transposed(&self, values: &DVector<f64>) -> DVector<f64> {
            values.clone()
        }

        fn first_hessian(&self, _: &DVector<f64>) -> Option<DMatrix<f64>> {
            Some(DMatrix::identity(2, 2))
        }
    }

    fn found(has_condition: bool, upper: f64) -> Minimum {
        let bounds = Bounds {
            lower: DVector::from_element(2, -3.0),
            upper: DVector::from_element(2, upper),
        };
        let start = DVector::from_vec(vec![0.5, 0.2]);
        minimise(&Quadratic { has_condition }, &bounds, start, 1e-10, 200).unwrap()
    }

    #[test]
    fn minima_are_found_inside_at_bounds_and_under_a_condition() {
        // 2 x + y = 6, x + 4 y = -4.
        let inside = found(false, 9.0);
        assert!((inside.x[0] - 4.0).abs() < 1e-6 && (inside.x[1] + 2.0).abs() < 1e-6);
        // x = 1, 4 y = -5.
        let at_bound = found(false, 1.0);
        assert!((at_bound.x[0] - 1.0).abs() < 1e-8 && (at_bound.x[1] + 1.25).abs() < 1e-6);
        assert!(at_bound.at_bounds && !inside.at_bounds);
        // On the circle the gradient is along the position.
        let circle = found(true, 9.0);
        let (x, y) = (circle.x[0], circle.x[1]);
        assert!(circle.violation < 1e-9);
        let gradient = (2.0 * (x - 3.0) + y, 4.0 * (y + 1.0) + x);
        assert!((gradient.0 * y - gradient.1 * x).abs() < 1e-5, "{x} {y}");
        assert!(x > 0.0 && y < 0.0);
    }
}
