//! The explicit Euler method, for comparison, with an estimate of its error.

use models::AccumulatedError;
use rigid::{State, StateVelocity};

use super::piece::{PathPiece, combination};
use super::result::{Accumulated, Approximation, SpanResult, Stopped};
use super::span_evaluator::SpanEvaluator;
use super::step_size::{largest_displacement, largest_rotation};

/// Integrates a phase span in equal steps, each with the velocity at its start.
pub(super) fn span(
    evaluator: &mut SpanEvaluator,
    start: &State,
    steps: usize,
) -> Result<SpanResult, Stopped> {
    let mut result = SpanResult::empty(start);
    let mut rates = Vec::new();
    for k in 0..steps {
        let span = (k as f64 / steps as f64, (k + 1) as f64 / steps as f64);
        let solution = match evaluator.solve(span.0, &result.end, true, None) {
            Err(error) => return Err(result.stopped(evaluator, error)),
            Ok(solution) => solution,
        };
        let duration = evaluator.span.duration * (span.1 - span.0);
        let rate = &solution.solution.motion * duration;
        rates.push(rate.clone());
        let piece = PathPiece::new(
            evaluator.scene.articulation(),
            &result.end,
            span,
            vec![rate],
        )?;
        if let Err(error) = evaluator.check_path(&piece) {
            return Err(result.stopped(evaluator, error));
        }
        let approximation = Approximation::new(piece, vec![solution], vec![1.0]);
        let accumulated = approximation.accumulated_error(duration);
        result.append(
            evaluator,
            approximation,
            None,
            accumulated.as_ref().map(Accumulated::Independent),
        )?;
    }
    result.accumulated_integration_error = integration_error(evaluator, &rates, start);
    Ok(result.with_totals(evaluator))
}

/// The error of steps with the velocity at their start, estimated from these velocities alone; none
/// for a single step, which gives no information on how the velocity changes.
///
/// The error of a step is the step minus the integral of a polynomial through the velocities of
/// neighbouring steps. With three steps or more the polynomials are quadratic (the weights of Adams
/// & Moulton, Hairer, Nørsett & Wanner 1993, III.1), and the difference from linear ones is the
/// uncertainty of the estimate. Errors of the rotation change the direction of later displacements.
/// The change of the velocity by an error of the position is neglected; near a wall this matters,
/// in proportion to the error of the position over the distance from the wall.
fn integration_error(
    evaluator: &SpanEvaluator,
    rates: &[StateVelocity],
    start: &State,
) -> Option<AccumulatedError> {
    if rates.len() < 2 {
        return None;
    }
    let weighted_sum = |terms: &[(usize, f64)]| {
        let terms = terms.iter().map(|&(step, weight)| (&rates[step], weight));
        combination(terms, start)
    };
    let last = rates.len() - 1;
    let linear = |step: usize| match step {
        step if step == last => weighted_sum(&[(last - 1, 0.5), (last, -0.5)]),
        step => weighted_sum(&[(step, 0.5), (step + 1, -0.5)]),
    };
    // h V_0 - h (5 V_1 + 8 V_0 - V_{-1}) / 12; at the ends the polynomial through the three nearest
    // velocities.
    let quadratic = |step: usize| {
        let terms = match step {
            0 => [(0, 7.0), (1, -8.0), (2, 1.0)],
            step if step == last => [(last - 2, -5.0), (last - 1, 16.0), (last, -11.0)],
            step => [(step - 1, 1.0), (step, 4.0), (step + 1, -5.0)],
        };
        weighted_sum(&terms.map(|(step, weight)| (step, weight / 12.0)))
    };
    let mut accumulated = AccumulatedError::default();
    let mut uncertainty = combination(std::iter::empty(), start);
    for (step, rate) in rates.iter().enumerate() {
        let (error, other) = if last < 2 {
            // Nothing to compare with: the uncertainty is as large as the estimate.
            (linear(step), combination(std::iter::empty(), start))
        } else {
            (quadratic(step), linear(step))
        };
        uncertainty = &uncertainty + &(&error + &(&other * -1.0));
        let step_error = AccumulatedError {
            displacement: error.frames.iter().map(|f| f.linear).collect(),
            rotation: error.frames.iter().map(|f| f.angular).collect(),
            ..AccumulatedError::default()
        };
        let displacement: Vec<_> = rate.frames.iter().map(|f| f.linear).collect();
        accumulated.append(&step_error, &displacement);
    }
    accumulated.uncertainty = largest_displacement(evaluator, &uncertainty);
    accumulated.rotation_uncertainty = largest_rotation(&uncertainty);
    Some(accumulated)
}
