//! Explicit Euler, the method to be compared with, and what it misses.

use rigid::{State, StateVelocity};

use super::leg_evaluator::LegEvaluator;
use super::piece::{PathPiece, combination};
use super::result::{LegResult, Rung};
use super::step_size::size;
use crate::SwimError;
use models::AccumulatedError;

/// Integrates a leg in equal steps, each at the velocity of its start.
pub(super) fn leg(
    evaluator: &mut LegEvaluator,
    start: &State,
    steps: usize,
) -> Result<LegResult, SwimError> {
    let mut result = LegResult::at(start);
    let mut rates = Vec::with_capacity(steps);
    for k in 0..steps {
        let span = (k as f64 / steps as f64, (k + 1) as f64 / steps as f64);
        let solved = evaluator.solve(span.0, &result.end, true)?;
        let duration = evaluator.leg.duration * (span.1 - span.0);
        let rate = &solved.solution.motion * duration;
        rates.push(rate.clone());
        let piece = PathPiece::new(
            evaluator.scene.articulation(),
            &result.end,
            span,
            vec![rate],
        )?;
        let rung = Rung {
            piece,
            solved: vec![solved],
            weights: vec![1.0],
        };
        let accumulated = rung.accumulated_error(duration);
        result.append(evaluator, rung, None, accumulated.as_ref())?;
    }
    result.accumulated_integration_error = missed(evaluator, &rates, start);
    Ok(result.closed(evaluator))
}

/// What steps at the velocity of their start err by, from these velocities alone: the steps less the integrals of a polynomial through
/// neighbouring velocities; none for a single step, which knows nothing of what changes.
///
/// With three steps and more the polynomials are quadratic (the weights of Adams & Moulton, Hairer, Nørsett & Wanner 1993, III.1), and the
/// difference to linear ones is what the estimate may err by. Wrong turns move wrongly later; that a wrong place changes the velocity itself
/// is left out, it matters beside walls by the part of the way to them that is missed.
fn missed(
    evaluator: &LegEvaluator,
    rates: &[StateVelocity],
    start: &State,
) -> Option<AccumulatedError> {
    if rates.len() < 2 {
        return None;
    }
    let mixed = |terms: &[(usize, f64)]| {
        let terms = terms.iter().map(|&(step, weight)| (&rates[step], weight));
        combination(terms, start)
    };
    let last = rates.len() - 1;
    let linear = |step: usize| match step {
        step if step == last => mixed(&[(last - 1, 0.5), (last, -0.5)]),
        step => mixed(&[(step, 0.5), (step + 1, -0.5)]),
    };
    // $h V_0 - h (5 V_1 + 8 V_0 - V_{-1}) / 12$; at the ends the polynomial of the three nearest velocities.
    let quadratic = |step: usize| {
        let parts = match step {
            0 => [(0, 7.0), (1, -8.0), (2, 1.0)],
            step if step == last => [(last - 2, -5.0), (last - 1, 16.0), (last, -11.0)],
            step => [(step - 1, 1.0), (step, 4.0), (step + 1, -5.0)],
        };
        mixed(&parts.map(|(step, weight)| (step, weight / 12.0)))
    };
    let mut accumulated = AccumulatedError::default();
    let mut unsure = combination(std::iter::empty(), start);
    for (step, rate) in rates.iter().enumerate() {
        let (error, other) = if last < 2 {
            // Nothing to compare with: the estimate may err by all of itself.
            (linear(step), combination(std::iter::empty(), start))
        } else {
            (quadratic(step), linear(step))
        };
        unsure = &unsure + &(&error + &(&other * -1.0));
        let own = AccumulatedError {
            displacement: error.frames.iter().map(|f| f.linear).collect(),
            rotation: error.frames.iter().map(|f| f.angular).collect(),
            uncertainty: 0.0,
        };
        let way: Vec<_> = rate.frames.iter().map(|f| f.linear).collect();
        accumulated.append(&own, &way);
    }
    accumulated.uncertainty = size(evaluator, &unsure);
    Some(accumulated)
}
