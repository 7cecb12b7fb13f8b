//! Sizes of steps, and the tolerances that they are compared with.

use std::f64::consts::PI;

use rigid::StateVelocity;
use scene::{Body, DrivingLoad, Scene};

use super::piece::PathPiece;
use super::span_evaluator::SpanEvaluator;
use crate::error::SwimError;
use crate::holding_loads::HoldingLoads;
use crate::mean_flow::MeanFlowInTime;

/// Tolerance for the error of a phase span whose net displacement is not predicted, as a fraction
/// of the scene's tolerance, relative to the displacement in the phase span or the change of
/// length.
///
/// The three-sphere swimmer of Najafi & Golestanian moves by 1/25 of the change of length of an
/// arm, and the errors of four phase spans add up.
const SPAN_TOLERANCE_SHARE: f64 = 1.0 / 160.0;

/// Smallest expected ratio of the errors of successive orders: for bodies far apart the velocity is
/// nearly linear, and its smooth part determines the errors. With a smaller one, noise of a
/// twentieth of the first change would look like convergence.
const MIN_RATIO: f64 = 0.05;

/// Largest expected ratio: beyond it, halving the step gains more than a higher order.
const MAX_RATIO: f64 = 0.5;

/// Largest number of equal parts of a phase span to which a step may shrink.
///
/// Steps towards a gap of `1e-4` of the length of the phase span have that length. Shorter steps
/// mean that something else than the step size is wrong.
pub(super) const MAX_PARTS: usize = 1 << 14;

/// Part of the error bar of the model's loads to which their impulses are integrated at most.
const BAR_SHARE: f64 = 0.1;

/// Part of the tolerance of a step that features of a table may have which its points do not see.
const UNSEEN_SHARE: f64 = 0.1;

/// Least number of equal parts of a phase span: quarters of the shortest period of loads and of the
/// periods of waves and frames, as for smooth gaits. Few points over whole periods would see
/// nothing of them, at every order.
pub(super) fn least_parts(evaluator: &SpanEvaluator) -> f64 {
    let (span, scene) = (&evaluator.span, evaluator.scene);
    let of_loads = (scene.shortest_period()).map_or(1.0, |period| 4.0 * span.duration / period);
    let of_waves = (scene.periodic_coordinates())
        .map(|(joint, period)| 4.0 * (span.to[joint] - span.from[joint]).abs() / period);
    // Turns are sums of decimal fractions, which exceed a quarter by rounding.
    let parts = (of_waves.fold(of_loads, f64::max) - 1e-9).ceil();
    parts.clamp(1.0, MAX_PARTS as f64)
}

/// The parts of a phase span that are tried first, in reverse order: the [`least_parts`], divided
/// at the rows of a table until what a few points do not see of it is small compared with the
/// tolerance.
pub(super) fn first_parts(evaluator: &SpanEvaluator) -> Vec<(f64, f64)> {
    let parts = least_parts(evaluator);
    let part = |k: usize| (k as f64 / parts, (k + 1) as f64 / parts);
    let mut todo: Vec<_> = (0..parts as usize).map(part).collect();
    let at_rest = StateVelocity {
        frames: Vec::new(),
        spins: Vec::new(),
        joints: Vec::new(),
    };
    let mut found = Vec::new();
    // From the last part to the first.
    while let Some(part) = todo.pop() {
        let allowed = UNSEEN_SHARE * step_tolerance(evaluator, &at_rest, part.1 - part.0);
        if unseen_displacement(evaluator, part) > allowed {
            let middle = evaluator.span.middle(part);
            todo.extend([(part.0, middle), (middle, part.1)]);
        } else {
            found.push(part);
        }
    }
    found
}

/// Displacement by features of a table over a part of the phase span that a step with few points
/// does not see ([`PhaseSpan::roughness`](scene::PhaseSpan::roughness)); zero between two rows.
pub(super) fn unseen_displacement(evaluator: &SpanEvaluator, part: (f64, f64)) -> f64 {
    let set = evaluator.scene.articulation();
    let roughness = evaluator.span.roughness(part).into_iter();
    let displacements = roughness.map(|(joint, distance)| set.arm_displacement(joint, distance));
    displacements.fold(0.0, f64::max)
}

/// Tolerance for a step along which no joint moves and no load oscillates, as a fraction of the
/// scene's tolerance: nothing returns, and the errors of steps add up as their displacements do.
const SHARE_WITHOUT_STROKE: f64 = 1.0 / 4.0;

/// Error that the scene's tolerance allows for a step of the Runge-Kutta pair over the part `width`
/// of the phase span.
pub(super) fn pair_tolerance(evaluator: &SpanEvaluator, step: &StateVelocity, width: f64) -> f64 {
    let tolerance = step_tolerance(evaluator, step, width);
    let returns = largest_length_change(evaluator) > 0.0
        || evaluator.scene.shortest_period().is_some()
        || evaluator.tolerance.is_some();
    match returns {
        true => tolerance,
        false => tolerance * SHARE_WITHOUT_STROKE / SPAN_TOLERANCE_SHARE,
    }
}

/// Error that the scene's tolerance allows for a step over the part `width` of the phase span.
pub(super) fn step_tolerance(evaluator: &SpanEvaluator, step: &StateVelocity, width: f64) -> f64 {
    match evaluator.tolerance {
        Some(tolerance) => tolerance * width,
        None => {
            let of_phase = largest_length_change(evaluator)
                .max(evaluator.moved)
                .max(driven_displacement(evaluator));
            let scale = largest_displacement(evaluator, step).max(width * of_phase);
            evaluator.scene.working_tolerance() * SPAN_TOLERANCE_SHARE * scale
        }
    }
}

/// Errors of the impulses of the force and of the torque that hold bodies, which the scene's
/// tolerance allows for a step with these impulses.
///
/// Mean loads are small differences of those of the phases, as displacements are. An error that is
/// small compared with that of the model makes the whole error bar no smaller.
pub(super) fn allowed_load_errors(evaluator: &SpanEvaluator, step: &HoldingLoads) -> [f64; 2] {
    let bodies = evaluator.scene.bodies().iter();
    let size = bodies.fold(longest_joint(evaluator), |size, body| {
        size.max(body.bounding_radius())
    });
    let share = evaluator.scene.working_tolerance() * SPAN_TOLERANCE_SHARE;
    let [force, torque] = step.largest();
    let bars = [&step.force_error, &step.torque_error].map(|bars| BAR_SHARE * bars.total());
    [
        (share * force).max(bars[0]),
        (share * torque.max(force * size)).max(bars[1]),
    ]
}

/// The same for the mean flow of a periodic box, of what the scene does not give.
pub(super) fn allowed_mean_flow_error(evaluator: &SpanEvaluator, step: &MeanFlowInTime) -> f64 {
    let size = step.difference(&MeanFlowInTime::default(), evaluator.scene);
    let share = evaluator.scene.working_tolerance() * SPAN_TOLERANCE_SHARE;
    (share * size).max(BAR_SHARE * step.error.total())
}

/// Ratio of the errors of successive orders of Gauss quadrature that contact causes.
///
/// Velocities are singular functions of the shape where bodies touch. With the distance `d` from
/// the end of a step of the length `w` to contact, errors decrease by
///
/// ```text
/// ρ^-2,   ρ = z + √(z² - 1),   z = 1 + 2 d / w
/// ```
///
/// per order (Trefethen 2008, SIAM Rev. 50, theorem 4.5). Each gap is continued linearly beyond the
/// end of `path` at which it is narrower, and the largest ratio counts.
pub(super) fn expected_ratio(
    evaluator: &SpanEvaluator,
    path: &PathPiece,
) -> Result<f64, SwimError> {
    let [from, to] = [path.from, path.to].map(|s| evaluator.gaps(path, s));
    let ratio_of = |(from, to): (f64, f64)| {
        let z = 1.0 + 2.0 * from.min(to).max(0.0) / (from - to).abs();
        (z + (z * z - 1.0).sqrt()).powi(-2)
    };
    // A gap that stays closed has no ratio; `max` leaves it out.
    let ratios = from?.into_iter().zip(to?).map(ratio_of);
    Ok(ratios.fold(MIN_RATIO, f64::max).min(MAX_RATIO))
}

/// Rounding error of a step: the positions of the bodies are sums of lengths of joints.
pub(super) fn rounding(evaluator: &SpanEvaluator, step: &StateVelocity) -> f64 {
    /// The positions enter the distances between bodies, of which each has a few operations.
    const OPERATIONS: f64 = 16.0;
    let size = longest_joint(evaluator).max(largest_displacement(evaluator, step));
    OPERATIONS * f64::EPSILON * size
}

/// Largest force and torque that vary on a body, with that of the field on its moment.
pub(super) fn largest_varying_loads(scene: &Scene, body: &Body) -> [f64; 2] {
    let field = scene.field().map_or(0.0, |field| field.largest().norm());
    let largest = |load: Option<DrivingLoad>| load.map_or(0.0, |l| l.vector.largest().norm());
    let torque = largest(body.driving_torque) + field * body.moment.norm();
    [largest(body.driving_force), torque]
}

/// Displacement over the phase span of a body alone, or of points of its surface, by the largest
/// loads that vary, and by all loads against a repulsion: such motions come to rest, where a step
/// has no size of its own.
fn driven_displacement(evaluator: &SpanEvaluator) -> f64 {
    let scene = evaluator.scene;
    let is_repelled = scene.repulsion().is_some();
    let speed = |body: &Body| {
        let radius = body.bounding_radius();
        let constant = if is_repelled {
            body.total_force().norm()
        } else {
            0.0
        };
        let [force, torque] = largest_varying_loads(scene, body);
        let drag = 6.0 * PI * scene.viscosity() * radius;
        let turning = 8.0 * PI * scene.viscosity() * radius * radius;
        (force + constant) / drag + torque / turning
    };
    let bodies = scene.bodies().iter();
    let driven =
        bodies.filter(|body| (is_repelled || body.is_driven()) && body.bounding_radius() > 0.0);
    evaluator.span.duration * driven.map(speed).fold(0.0, f64::max)
}

/// The largest displacement by one joint over the phase span.
fn largest_length_change(evaluator: &SpanEvaluator) -> f64 {
    let set = evaluator.scene.articulation();
    let ranges = evaluator.ranges.iter().enumerate();
    let changes = ranges.map(|(joint, (low, high))| set.arm_displacement(joint, high - low));
    changes.fold(0.0, f64::max)
}

/// Size of a step: the largest displacement of a body's centre or, by its own rotation, of its
/// surface.
pub(super) fn largest_displacement(evaluator: &SpanEvaluator, step: &StateVelocity) -> f64 {
    let longest_joint = longest_joint(evaluator);
    let set = evaluator.scene.articulation();
    let radii = evaluator.scene.bodies().iter();
    // A body without joints moves its surface alone.
    let lever = match longest_joint > 0.0 {
        true => longest_joint,
        false => radii.fold(0.0, |most: f64, body| most.max(body.bounding_radius())),
    };
    let joints = (set.passive_drives().zip(&step.joints))
        .map(|((joint, _), change)| set.arm_displacement(joint, *change));
    let spins = step
        .spins
        .iter()
        .zip(evaluator.scene.bodies())
        .map(|(spin, body)| spin.norm() * body.bounding_radius());
    step.frames
        .iter()
        .map(|f| f.linear.norm() + f.angular.norm() * lever)
        .chain(spins)
        .chain(joints)
        .fold(0.0, f64::max)
}

/// The largest rotation of a frame or of a body about its own axis in a step.
pub(super) fn largest_rotation(step: &StateVelocity) -> f64 {
    let frames = step.frames.iter().map(|frame| frame.angular.norm());
    let spins = step.spins.iter().map(|spin| spin.norm());
    frames.chain(spins).fold(0.0, f64::max)
}

/// Largest distance of two joined bodies along the phase span.
fn longest_joint(evaluator: &SpanEvaluator) -> f64 {
    let set = evaluator.scene.articulation();
    let ranges = evaluator.ranges.iter().enumerate();
    let lengths = ranges.map(|(joint, (_, high))| set.arm_length(joint, *high));
    lengths.fold(0.0, f64::max)
}
