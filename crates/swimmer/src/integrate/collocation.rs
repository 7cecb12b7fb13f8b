//! Gauss collocation on the group of states, by a ladder of orders.
//!
//! In coordinates $\sigma$ about the middle of the step, $X(t) = \exp(\sigma(t)) X_m$, the motion is
//! $\sigma' = \mathrm{dexp}^{-1}_\sigma V(X)$. The polynomial through the rates at $n$ Gauss points is exact to order $2n$
//! (Hairer, Lubich & Wanner 2006, II.1), and symmetric because coordinates are centred (Zanna, Engø & Munthe-Kaas 2001).
//! The velocity of a swimmer depends on its shape strongly and on its position weakly. So the points of each
//! order are placed on the path that the order before has found: every rung of the ladder refines the quadrature
//! and the positions at once, and the change from rung to rung measures both.

use nalgebra::Vector3;
use rigid::{State, StateVelocity};

use super::gauss::Gauss;
use super::leg_evaluator::LegEvaluator;
use super::leg_solution::LegSolution;
use super::piece::{PathPiece, combination};
use super::result::{LegResult, Rung};
use super::rotation::coordinate_rate;
use super::step_size::{LEG_SHARE, MOST_PARTS, moved, size};
use crate::SwimError;

/// Rungs from this one on are asked with estimates of what the mesh gets wrong, because they may be the last. (The estimates of
/// one rung do not serve another: its meshes err by other accidents.)
const ESTIMATED_POINTS: usize = 3;

/// Rungs beyond this gain less than halving the step does.
const MOST_POINTS: usize = 8;

/// Rungs that still differ by less than this, but no longer come closer, differ by the model's own noise
/// (a mesh of 28 thousand unknowns moves velocities by 1e-4, measured; coarser ones by more).
const NOISE: f64 = 1e-3;

/// No rung is trusted to gain more than this: an accident of one change must not look like convergence.
const LEAST_GAIN: f64 = 0.1;

/// Integrates a leg, halving steps where the ladder of orders does not converge.
pub(super) fn leg(evaluator: &mut LegEvaluator, start: &State) -> Result<LegResult, SwimError> {
    let mut result = LegResult::at(start);
    let mut todo = vec![(0.0, 1.0)];
    while let Some(span) = todo.pop() {
        let middle = 0.5 * (span.0 + span.1);
        let may_halve = span.1 - span.0 > 1.0 / MOST_PARTS as f64;
        match step(evaluator, &result.end, span) {
            Ok(Step::Done { rung, error, met }) => {
                let duration = evaluator.leg.duration * (span.1 - span.0);
                let accumulated = rung.accumulated_error(duration);
                result.append(evaluator, *rung, Some(error), accumulated.as_ref())?;
                result.tolerance_met &= met;
            }
            Ok(Step::Diverging { .. }) | Err(SwimError::Collision { .. }) if may_halve => {
                todo.extend([(middle, span.1), (span.0, middle)]);
            }
            Ok(Step::Diverging { error, tolerance }) => {
                return Err(SwimError::NotIntegrated {
                    phase: evaluator.leg.number + 1,
                    what: evaluator.what(),
                    error,
                    tolerance,
                    parts: MOST_PARTS,
                });
            }
            Err(error) => return Err(error),
        }
    }
    Ok(result.closed(evaluator))
}

enum Step {
    Done {
        rung: Box<Rung>,
        error: f64,
        met: bool,
    },
    Diverging {
        error: f64,
        tolerance: f64,
    },
}

/// Climbs the ladder over one part of a leg until a rung changes the step by less than the tolerance.
fn step(evaluator: &mut LegEvaluator, start: &State, span: (f64, f64)) -> Result<Step, SwimError> {
    let set = evaluator.scene.articulation();
    let width = span.1 - span.0;
    let guess = PathPiece::new(
        set,
        start,
        span,
        vec![resting_centroids(evaluator, start, span)?],
    )?;
    let mut before = climb(evaluator, start, &guess, 1, false)?;
    let mut last_change = None;
    let mut gain = LEAST_GAIN;
    for points in 2..=MOST_POINTS {
        let requested = points >= ESTIMATED_POINTS;
        let mut rung = climb(evaluator, start, &before.piece, points, requested)?;
        let (step, step_before) = (rung.piece.step(), before.piece.step());
        let change = size(evaluator, &(&step + &(&step_before * -1.0)));
        let scale = size(evaluator, &step).max(width * moved(evaluator));
        let tolerance = evaluator.scene.model().tolerance * LEG_SHARE * scale;
        // A change is the error of the rung before; this rung's error is smaller by what a rung gains.
        if let Some(last) = last_change {
            gain = gain.max(change / last);
        }
        let error = if last_change.is_some() {
            change * gain.min(1.0)
        } else {
            change
        };
        if error <= tolerance {
            // Sooner than expected: the same points again, with estimates.
            let estimates = evaluator.error_estimates();
            if !estimates.given(requested) && estimates.given(true) {
                rung = climb(evaluator, start, &before.piece, points, true)?;
            }
            return Ok(Step::Done {
                rung: Box::new(rung),
                error,
                met: true,
            });
        }
        let stalled = last_change.is_some_and(|last| change > 0.5 * last);
        if stalled && change <= NOISE * scale {
            return Ok(Step::Done {
                rung: Box::new(rung),
                error: change,
                met: false,
            });
        }
        if stalled || points == MOST_POINTS {
            return Ok(Step::Diverging { error, tolerance });
        }
        (before, last_change) = (rung, Some(change));
    }
    Ok(Step::Diverging {
        error: f64::INFINITY,
        tolerance: 0.0,
    })
}

/// One rung: asks at the Gauss points of the path found so far.
fn climb(
    evaluator: &mut LegEvaluator,
    start: &State,
    path: &PathPiece,
    points: usize,
    estimates: bool,
) -> Result<Rung, SwimError> {
    let set = evaluator.scene.articulation();
    let span = (path.from, path.to);
    let duration = evaluator.leg.duration * (span.1 - span.0);
    let gauss = Gauss::new(points);
    let mut piece = path.clone();
    let mut solved = Vec::with_capacity(points);
    for &t in &gauss.nodes {
        let s = span.0 + t * (span.1 - span.0);
        solved.push(evaluator.solve(s, &piece.state(set, s)?, estimates)?);
    }
    let rates = |piece: &PathPiece, solved: &[LegSolution]| -> Vec<StateVelocity> {
        let rate = |(s, &t): (&LegSolution, &f64)| {
            &coordinate_rate(&piece.coordinates(t), &s.solution.motion) * duration
        };
        solved.iter().zip(&gauss.nodes).map(rate).collect()
    };
    piece = PathPiece::new(set, start, span, rates(&piece, &solved))?;
    if evaluator.scene.is_free() {
        // The shape alone matters, so the same answers serve the corrected positions: iterate to rounding.
        for _ in 0..FREE_SWEEPS {
            for (solved, &t) in solved.iter_mut().zip(&gauss.nodes) {
                *solved =
                    evaluator.turned(solved, &piece.state(set, span.0 + t * (span.1 - span.0))?);
            }
            let next = PathPiece::new(set, start, span, rates(&piece, &solved))?;
            let change = size(evaluator, &(&next.step() + &(&piece.step() * -1.0)));
            piece = next;
            if change <= f64::EPSILON * size(evaluator, &piece.step()) {
                break;
            }
        }
    }
    Ok(Rung {
        piece,
        solved,
        weights: gauss.weights,
    })
}

/// Sweeps that fix the rotation of a free swimmer: each gains a factor of the angle turned in a leg, below 0.3.
const FREE_SWEEPS: usize = 40;

/// A first guess of the motion over a span: the mean position of every linkage's bodies stays.
fn resting_centroids(
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
