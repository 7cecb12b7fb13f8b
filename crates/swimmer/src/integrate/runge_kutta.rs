//! A Runge-Kutta pair on the group of states; the embedded formula controls the error of each step.
//!
//! In coordinates `sigma` about the start of a step, `X(t) = exp(sigma(t)) X_0`, the equation of
//! motion `sigma' = dexp^-1_sigma V(X)` is an equation in a vector space, where the pair of Dormand
//! & Prince (J. Comput. Appl. Math. 6, 1980) of orders 5 and 4 keeps its orders (Munthe-Kaas, BIT
//! 38, 1998). Its last stage is the velocity at the end of the step, so a step costs six solves,
//! and the path between its ends is the cubic through these and their velocities.

use rigid::{State, StateVelocity};

use super::inverse_dexp::coordinate_rate;
use super::piece::{PathPiece, combination};
use super::result::{
    Approximation, IntegralErrors, Integrals, IntegrationError, SpanResult, Stopped,
};
use super::span_evaluator::{SpanEvaluator, SpanSolution};
use super::step_size::{
    MAX_PARTS, largest_displacement, largest_rotation, least_parts, pair_tolerance,
    unseen_displacement,
};
use crate::error::SwimError;
use crate::holding_loads::HoldingLoads;

const NODES: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

const STAGES: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[
        19372.0 / 6561.0,
        -25360.0 / 2187.0,
        64448.0 / 6561.0,
        -212.0 / 729.0,
    ],
    &[
        9017.0 / 3168.0,
        -355.0 / 33.0,
        46732.0 / 5247.0,
        49.0 / 176.0,
        -5103.0 / 18656.0,
    ],
    &[
        35.0 / 384.0,
        0.0,
        500.0 / 1113.0,
        125.0 / 192.0,
        -2187.0 / 6784.0,
        11.0 / 84.0,
    ],
];

/// Weights of the formula of order five, equal to those of the last stage.
const WEIGHTS: [f64; 7] = [
    35.0 / 384.0,
    0.0,
    500.0 / 1113.0,
    125.0 / 192.0,
    -2187.0 / 6784.0,
    11.0 / 84.0,
    0.0,
];

/// Weights of the formula of order five minus those of the formula of order four.
const DIFFERENCE: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// Length of the first step that is tried, as a fraction of the phase span.
const FIRST_WIDTH: f64 = 0.25;

/// Integrates a phase span with the longest steps that meet the tolerance.
pub(super) fn span(evaluator: &mut SpanEvaluator, start: &State) -> Result<SpanResult, Stopped> {
    let mut result = SpanResult::empty(start);
    let widest = 1.0 / least_parts(evaluator);
    let (mut s, mut width) = (0.0, FIRST_WIDTH.min(widest));
    let mut first = evaluator.solve(0.0, start, false, None)?;
    while s < 1.0 {
        // No separate step for a remainder that is due to rounding.
        let end = if s + 1.01 * width >= 1.0 {
            1.0
        } else {
            s + width
        };
        let may_halve = end - s > 1.0 / MAX_PARTS as f64;
        let step = match step(evaluator, &result.end, &first, (s, end)) {
            Err(error) if error.is_overshoot() && may_halve => {
                width = 0.5 * (end - s);
                continue;
            }
            Err(error) => return Err(result.stopped(evaluator, error)),
            Ok(step) => step,
        };
        let tolerance = pair_tolerance(evaluator, &step.sigma, end - s);
        // The step size for a local error of order five, changed by at most a factor of five
        // (Hairer, Nørsett & Wanner 1993, II.4).
        let factor = match step.error > 0.0 {
            true => (0.9 * (tolerance / step.error).powf(0.2)).clamp(0.2, 5.0),
            false => 5.0,
        };
        if step.error > tolerance {
            if !may_halve {
                let error = evaluator.not_integrated(step.error, tolerance, MAX_PARTS);
                return Err(result.stopped(evaluator, error));
            }
            width = factor.min(1.0) * (end - s);
            continue;
        }
        let piece = PathPiece::hermite(
            evaluator.scene.articulation(),
            &result.end,
            (s, end),
            &step.sigma,
            [&first, &step.last].map(|solution| &solution.solution.motion),
            evaluator.span.duration * (end - s),
        )?;
        match evaluator.check_path(&piece) {
            Err(error) if error.is_overshoot() && may_halve => {
                width = 0.5 * (end - s);
                continue;
            }
            Err(error) => return Err(result.stopped(evaluator, error)),
            Ok(()) => {}
        }
        first = step.last;
        let stages = step.solutions.len();
        let approximation = Approximation {
            integral_errors: Some(step.integral_errors),
            ..Approximation::new(piece, step.solutions, WEIGHTS[..stages].to_vec())
        };
        let error = IntegrationError {
            displacement: step.error,
            rotation: step.rotation_error,
            work: step.work_error,
            holding: step.holding_errors,
        };
        result.append(evaluator, approximation, Some(error.unsigned()), None)?;
        result.keep_first_stage(stages);
        (s, width) = (end, (factor * (end - s)).min(widest));
    }
    result.end_with(first);
    Ok(result.with_totals(evaluator))
}

struct Step {
    /// The step in coordinates about its start.
    sigma: StateVelocity,
    /// Estimated error of the step.
    error: f64,
    /// Estimated error of the rotation.
    rotation_error: f64,
    /// Estimated error of the work.
    work_error: f64,
    /// Estimated errors of the impulses that hold bodies.
    holding_errors: [f64; 2],
    /// Estimated errors of works of linkages and of the mean flow.
    integral_errors: IntegralErrors,
    /// Solutions of all stages but the last.
    solutions: Vec<SpanSolution>,
    /// The solution at the end of the step.
    last: SpanSolution,
}

fn step(
    evaluator: &mut SpanEvaluator,
    start: &State,
    first: &SpanSolution,
    span: (f64, f64),
) -> Result<Step, SwimError> {
    let set = evaluator.scene.articulation();
    let width = span.1 - span.0;
    let duration = evaluator.span.duration * width;
    let mut solutions = vec![first.clone()];
    let at_start = combination(std::iter::empty(), start);
    let mut rates = vec![&coordinate_rate(set, &at_start, &first.solution.motion) * duration];
    for (weights, node) in STAGES.iter().zip(&NODES[1..]) {
        let sigma = combination(rates.iter().zip(weights.iter().copied()), start);
        let state = set.advance(start, &sigma)?;
        let stage = evaluator.solve(span.0 + node * width, &state, false, None)?;
        rates.push(&coordinate_rate(set, &sigma, &stage.solution.motion) * duration);
        solutions.push(stage);
    }
    let error = combination(rates.iter().zip(DIFFERENCE), start);
    let powers = solutions.iter().map(|stage| stage.solution.power());
    let work_difference: f64 = powers.zip(DIFFERENCE).map(|(p, d)| d * p).sum();
    let weighted = solutions.iter().map(|stage| &stage.solution);
    let weighted = weighted.zip(DIFFERENCE.map(|d| d * duration));
    let holding_errors = HoldingLoads::impulses(weighted.clone()).largest();
    let integral_errors = Integrals::new(evaluator.scene, weighted)
        .change_from(&Integrals::default(), evaluator.scene);
    let last = solutions.split_off(NODES.len() - 1).swap_remove(0);
    Ok(Step {
        sigma: combination(rates.iter().zip(WEIGHTS), start),
        error: largest_displacement(evaluator, &error) + unseen_displacement(evaluator, span),
        rotation_error: largest_rotation(&error),
        work_error: (duration * work_difference).abs(),
        holding_errors,
        integral_errors,
        solutions,
        last,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tableau_satisfies_the_quadrature_order_conditions() {
        for (row, node) in STAGES.iter().zip(&NODES[1..]) {
            assert!((row.iter().sum::<f64>() - node).abs() < 1e-14);
        }
        // Quadrature conditions: order five for the weights, order four for the embedded ones.
        for power in 0..5 {
            let moment = |weights: &[f64]| -> f64 {
                weights
                    .iter()
                    .zip(NODES)
                    .map(|(w, c)| w * c.powi(power))
                    .sum()
            };
            let exact = 1.0 / f64::from(power + 1);
            assert!((moment(&WEIGHTS) - exact).abs() < 1e-14);
            let embedded: Vec<f64> = WEIGHTS.iter().zip(DIFFERENCE).map(|(w, d)| w - d).collect();
            assert_eq!((moment(&embedded) - exact).abs() < 1e-14, power < 4);
        }
        assert_eq!(STAGES[5], &WEIGHTS[..6]);
    }
}
