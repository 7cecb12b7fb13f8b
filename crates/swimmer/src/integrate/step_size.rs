//! Sizes of steps, and the tolerances that they are measured against.

use rigid::StateVelocity;

use super::leg_evaluator::LegEvaluator;

/// Share of the tolerance for the error of a leg, relative to the leg's displacement or change of length.
///
/// A stroke is a small difference of its legs: the three-sphere swimmer of Najafi & Golestanian moves by 1/25 of an arm's
/// change, and the errors of four legs add up. A stroke that gains less, such as the planar swimmer's (1/370),
/// may miss the tolerance; that is found at the end, when the net displacement is known.
pub(super) const LEG_SHARE: f64 = 1.0 / 160.0;

/// Steps below this part of a leg mean that something other than the step is wrong.
pub(super) const MOST_PARTS: usize = 64;

/// The largest change of a length over the leg.
pub(super) fn moved(evaluator: &LegEvaluator) -> f64 {
    let changes = evaluator.leg.from.iter().zip(&evaluator.leg.to);
    changes.fold(0.0_f64, |m, (a, b)| m.max((b - a).abs()))
}

/// Size of a step as the largest displacement of a body's centre or, by spinning, of its surface.
pub(super) fn size(evaluator: &LegEvaluator, step: &StateVelocity) -> f64 {
    let reach = evaluator
        .leg
        .from
        .iter()
        .chain(&evaluator.leg.to)
        .fold(0.0_f64, |m, l| m.max(*l));
    let spins = step
        .spins
        .iter()
        .zip(evaluator.scene.bodies())
        .map(|(spin, body)| spin.norm() * body.bounding_radius());
    step.frames
        .iter()
        .map(|f| f.linear.norm() + f.angular.norm() * reach)
        .chain(spins)
        .fold(0.0, f64::max)
}
