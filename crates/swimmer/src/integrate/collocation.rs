//! Gauss collocation on the group of states, with increasing order.
//!
//! In coordinates `sigma` about the middle of the step, `X(t) = exp(sigma(t)) X_m`, the equation of
//! motion is `sigma' = dexp^-1_sigma V(X)`. The polynomial through the rates at `n` Gauss points
//! has order `2n` (Hairer, Lubich & Wanner 2006, II.1), and the method is symmetric because the
//! coordinates are centred (Zanna, Engø & Munthe-Kaas 2001). The velocity of a swimmer depends
//! strongly on its shape and weakly on its position. Therefore the Gauss points of each order are
//! placed on the path of the order before: every increase of the order improves the quadrature and
//! the positions at once, and the change of the step measures the error of both.

use nalgebra::Vector3;
use rigid::{State, StateVelocity};

use super::gauss::Gauss;
use super::inverse_dexp::coordinate_rate;
use super::leg_evaluator::LegEvaluator;
use super::leg_solution::LegSolution;
use super::piece::{PathPiece, combination};
use super::result::{Approximation, LegResult};
use super::step_size::{
    LEG_TOLERANCE_SHARE, MAX_PARTS, largest_displacement, largest_length_change,
};
use crate::error::SwimError;

/// From this number of points on, solutions are requested with estimates of the discretisation
/// error, because this order may be accepted. (Estimates of one order cannot serve another: its
/// solutions belong to other meshes, whose discretisation errors differ.)
const FIRST_ESTIMATED: usize = 3;

/// Largest number of points: beyond it, halving the step gains more.
const MAX_POINTS: usize = 8;

/// Relative change between two orders below which a change that no longer decreases is taken for
/// noise of the model (velocities on a mesh of 28 thousand degrees of freedom have noise of 1e-4,
/// measured; on coarser meshes more).
const NOISE: f64 = 1e-3;

/// Smallest ratio of the errors of successive orders that is trusted: a single small change by
/// chance must not look like convergence.
const MIN_REDUCTION: f64 = 0.1;

/// Integrates a leg; halves the step where increasing the order does not converge.
pub(super) fn leg(evaluator: &mut LegEvaluator, start: &State) -> Result<LegResult, SwimError> {
    let mut result = LegResult::empty(start);
    let mut todo = vec![(0.0, 1.0)];
    while let Some(span) = todo.pop() {
        let middle = 0.5 * (span.0 + span.1);
        let may_halve = span.1 - span.0 > 1.0 / MAX_PARTS as f64;
        match step(evaluator, &result.end, span) {
            Ok(Step::Accepted {
                approximation,
                error,
                tolerance_met,
            }) => {
                let duration = evaluator.leg.duration * (span.1 - span.0);
                let accumulated = approximation.accumulated_error(duration);
                result.append(evaluator, *approximation, Some(error), accumulated.as_ref())?;
                result.tolerance_met &= tolerance_met;
            }
            Ok(Step::Diverging { .. }) | Err(SwimError::Collision { .. }) if may_halve => {
                todo.extend([(middle, span.1), (span.0, middle)]);
            }
            Ok(Step::Diverging { error, tolerance }) => {
                return Err(SwimError::NotIntegrated {
                    phase: evaluator.leg.number + 1,
                    link: evaluator.link_name(),
                    error,
                    tolerance,
                    parts: MAX_PARTS,
                });
            }
            Err(error) => return Err(error),
        }
    }
    Ok(result.with_totals(evaluator))
}

enum Step {
    Accepted {
        approximation: Box<Approximation>,
        error: f64,
        tolerance_met: bool,
    },
    Diverging {
        error: f64,
        tolerance: f64,
    },
}

/// Increases the order over one part of a leg until the estimated error is below the tolerance.
fn step(evaluator: &mut LegEvaluator, start: &State, span: (f64, f64)) -> Result<Step, SwimError> {
    let set = evaluator.scene.articulation();
    let width = span.1 - span.0;
    let guess = PathPiece::new(
        set,
        start,
        span,
        vec![fixed_centroids(evaluator, start, span)?],
    )?;
    let mut previous = collocate(evaluator, start, &guess, 1, false)?;
    let mut last_change = None;
    let mut reduction = MIN_REDUCTION;
    for points in 2..=MAX_POINTS {
        let requested = points >= FIRST_ESTIMATED;
        let mut current = collocate(evaluator, start, &previous.piece, points, requested)?;
        let (step, previous_step) = (current.piece.step(), previous.piece.step());
        let change = largest_displacement(evaluator, &(&step + &(&previous_step * -1.0)));
        let scale =
            largest_displacement(evaluator, &step).max(width * largest_length_change(evaluator));
        let tolerance = evaluator.scene.model().tolerance * LEG_TOLERANCE_SHARE * scale;
        // The change is the error of the previous order; the error of this order is smaller by the
        // factor by which the changes decrease.
        if let Some(last) = last_change {
            reduction = reduction.max(change / last);
        }
        let error = if last_change.is_some() {
            change * reduction.min(1.0)
        } else {
            change
        };
        if error <= tolerance {
            // Accepted at a lower order than expected: the same points again, with estimates.
            let estimates = evaluator.error_estimates();
            if !estimates.given(requested) && estimates.given(true) {
                current = collocate(evaluator, start, &previous.piece, points, true)?;
            }
            return Ok(Step::Accepted {
                approximation: Box::new(current),
                error,
                tolerance_met: true,
            });
        }
        let stalled = last_change.is_some_and(|last| change > 0.5 * last);
        if stalled && change <= NOISE * scale {
            return Ok(Step::Accepted {
                approximation: Box::new(current),
                error: change,
                tolerance_met: false,
            });
        }
        if stalled || points == MAX_POINTS {
            return Ok(Step::Diverging { error, tolerance });
        }
        (previous, last_change) = (current, Some(change));
    }
    Ok(Step::Diverging {
        error: f64::INFINITY,
        tolerance: 0.0,
    })
}

/// Collocation with `points` Gauss points on the path found so far.
fn collocate(
    evaluator: &mut LegEvaluator,
    start: &State,
    path: &PathPiece,
    points: usize,
    estimates: bool,
) -> Result<Approximation, SwimError> {
    let set = evaluator.scene.articulation();
    let span = (path.from, path.to);
    let duration = evaluator.leg.duration * (span.1 - span.0);
    let gauss = Gauss::new(points);
    let mut piece = path.clone();
    let mut solutions = Vec::with_capacity(points);
    for &t in &gauss.nodes {
        let s = span.0 + t * (span.1 - span.0);
        solutions.push(evaluator.solve(s, &piece.state(set, s)?, estimates)?);
    }
    let rates = |piece: &PathPiece, solutions: &[LegSolution]| -> Vec<StateVelocity> {
        let rate = |(s, &t): (&LegSolution, &f64)| {
            &coordinate_rate(&piece.coordinates(t), &s.solution.motion) * duration
        };
        solutions.iter().zip(&gauss.nodes).map(rate).collect()
    };
    piece = PathPiece::new(set, start, span, rates(&piece, &solutions))?;
    if evaluator.scene.is_free() {
        // The motion depends on the shape alone, so the same solutions, rotated, hold on the
        // corrected path: iterate to rounding.
        for _ in 0..MAX_ROTATION_SWEEPS {
            for (solution, &t) in solutions.iter_mut().zip(&gauss.nodes) {
                *solution =
                    evaluator.rotated(solution, &piece.state(set, span.0 + t * (span.1 - span.0))?);
            }
            let next = PathPiece::new(set, start, span, rates(&piece, &solutions))?;
            let change = largest_displacement(evaluator, &(&next.step() + &(&piece.step() * -1.0)));
            piece = next;
            if change <= f64::EPSILON * largest_displacement(evaluator, &piece.step()) {
                break;
            }
        }
    }
    Ok(Approximation {
        piece,
        solutions,
        weights: gauss.weights,
    })
}

/// Largest number of fixed-point iterations for the rotation of a free swimmer; each reduces the
/// error by a factor of the rotation angle of a leg, below 0.3.
const MAX_ROTATION_SWEEPS: usize = 40;

/// Initial guess of the motion over a span: the mean position of the bodies of every linkage stays.
fn fixed_centroids(
    evaluator: &LegEvaluator,
    start: &State,
    span: (f64, f64),
) -> Result<StateVelocity, SwimError> {
    let set = evaluator.scene.articulation();
    let before = set.place(start, &evaluator.leg.lengths(span.0))?;
    let after = set.place(start, &evaluator.leg.lengths(span.1))?;
    let mut guess = combination(std::iter::empty(), start);
    for (frame, linkage) in guess.frames.iter_mut().zip(set.linkages()) {
        let shift =
            |&body: &usize| before[body].translation.vector - after[body].translation.vector;
        frame.linear =
            linkage.bodies.iter().map(shift).sum::<Vector3<f64>>() / linkage.bodies.len() as f64;
    }
    Ok(guess)
}
