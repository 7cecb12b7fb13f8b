//! Sizes of steps, and the tolerances that they are compared with.

use rigid::StateVelocity;

use super::leg_evaluator::LegEvaluator;

/// Tolerance for the error of a leg, as a fraction of the scene's tolerance.
///
/// It is relative to the displacement in the leg or the change of length, while the scene's
/// tolerance is relative to the net displacement, a small difference of the legs. The three-sphere
/// swimmer of Najafi & Golestanian moves by 1/25 of the change of length of an arm, and the errors
/// of four legs add up. A swimmer with a smaller net displacement, such as the planar one (1/370),
/// may miss the tolerance; this is detected at the end, when the net displacement is known.
pub(super) const LEG_TOLERANCE_SHARE: f64 = 1.0 / 160.0;

/// Largest number of parts of a leg: shorter steps mean that something else than the step size is
/// wrong.
pub(super) const MAX_PARTS: usize = 64;

/// The largest change of a link's length over the leg.
pub(super) fn largest_length_change(evaluator: &LegEvaluator) -> f64 {
    let changes = evaluator.leg.from.iter().zip(&evaluator.leg.to);
    changes.fold(0.0_f64, |m, (a, b)| m.max((b - a).abs()))
}

/// Size of a step: the largest displacement of a body's centre or, by its own rotation, of its
/// surface.
pub(super) fn largest_displacement(evaluator: &LegEvaluator, step: &StateVelocity) -> f64 {
    let longest_link = evaluator
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
        .map(|f| f.linear.norm() + f.angular.norm() * longest_link)
        .chain(spins)
        .fold(0.0, f64::max)
}
