//! Prediction of the displacements in one cycle, from which tolerances of its parts follow.

use models::{Hydrodynamics, RoughModel};
use nalgebra::Vector3;
use scene::{Scene, spans};

use super::collocation;
use super::span_evaluator::SpanEvaluator;
use crate::outcome::{mean_of_moving, positions};

/// Displacements in the first cycle of a gait, predicted by [`RoughModel`].
///
/// The tolerance of a scene is relative to the net displacement of a cycle, which is a small
/// difference of the displacements of the phases: 1/25 of the change of length of an arm for the
/// swimmer of Najafi & Golestanian, 1/370 for the planar one. The prediction says how small. An
/// error of it changes the number of solves, not the error bars.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Prediction {
    /// Net displacement, or a substitute for one that is too small to be predicted.
    net: f64,
    /// Longest displacement of a body in one phase; of points of its surface by rotation, if
    /// centres do not move.
    longest: f64,
    /// Number of phases in a cycle.
    phases: usize,
}

/// Largest number of bodies for which displacements are predicted; the prediction takes 5 solves
/// per phase with dense matrices.
const MAX_BODIES: usize = 30;

/// Gauss points per phase: the error is small compared with that of [`RoughModel`].
const POINTS: usize = 4;

/// Phases of a cycle above which each is short enough for one Gauss point.
const MANY_PHASES: usize = 200;

/// Predicted net displacement relative to the longest one, below which the gait counts as
/// reciprocal: its net displacement vanishes up to rounding and the error of the quadrature.
const MAX_RECIPROCAL_RATIO: f64 = 1e-6;

/// Ratio of the net displacement to the longest displacement in a phase that is assumed for a
/// reciprocal gait; the swimmer of Najafi & Golestanian has 0.06.
const TYPICAL_NET_RATIO: f64 = 0.04;

/// Smallest ratio that is used: below it, as for a gait that does not quite close, tolerances are
/// relative to this ratio.
const MIN_NET_RATIO: f64 = 1e-3;

/// Part of the tolerance that the integration may use; the rest is for errors of the model and of
/// the prediction, which is right within a factor of two where bodies come close.
const INTEGRATION_SHARE: f64 = 0.5;

/// Part of the tolerance of the integration that errors of the model may use, so that they do not
/// look like errors of the integration.
const MODEL_SHARE: f64 = 0.6;

impl Prediction {
    /// The prediction for a scene; none without a gait, with many bodies, slip, a background
    /// flow or periodic images, loads or given velocities that vary, or if nothing moves.
    pub fn from_scene(scene: &Scene) -> Option<Self> {
        // The rough model ignores slip, background flows and periodic images, and its few points
        // repulsion.
        let is_smooth = !scene.has_surface_velocity()
            && scene.repulsion().is_none()
            && scene.domain().period().is_none();
        if scene.bodies().len() > MAX_BODIES || !is_smooth {
            return None;
        }
        // A few points per phase do not follow bodies that turn many times in a field, and one that
        // oscillates may be where it started.
        if scene.depends_on_time() || scene.bodies().iter().any(scene::Body::is_driven) {
            return None;
        }
        let mut model = RoughModel::new(scene).ok()?;
        let set = scene.articulation();
        let mut state = scene.initial_state();
        let mut before = positions(set, &state, set.initial_shape()).ok()?;
        let origin = before.clone();
        let (mut longest, mut arc) = (0.0_f64, 0.0_f64);
        let phases = scene.gait().phases.len();
        let spans = spans(scene.gait(), set.initial_shape()).ok()?;
        let points = if phases > MANY_PHASES { 1 } else { POINTS };
        for span in spans.take(phases) {
            let mut observe = |_: &_, _: &dyn Hydrodynamics| Ok(());
            let mut evaluator = SpanEvaluator::new(scene, &mut model, &span, None, &mut observe);
            let motion = collocation::fixed_order(&mut evaluator, &state, points).ok()?;
            state = motion.piece.state(set, 1.0).ok()?;
            for (number, body) in scene.bodies().iter().enumerate() {
                let angle = motion.turning_angle(number, span.duration);
                arc = arc.max(angle * body.bounding_radius());
            }
            let after = positions(set, &state, &span.to).ok()?;
            let moved = after.iter().zip(&before).map(|(a, b)| (a - b).norm());
            longest = moved.fold(longest, f64::max);
            before = after;
        }
        let displacement: Vec<Vector3<f64>> =
            before.iter().zip(&origin).map(|(a, b)| a - b).collect();
        let net = mean_of_moving(&displacement).norm();
        if longest <= MAX_RECIPROCAL_RATIO * arc {
            longest = arc;
        }
        let is_reciprocal = net <= MAX_RECIPROCAL_RATIO * longest;
        (longest > 0.0 && longest.is_finite()).then_some(Self {
            net: match is_reciprocal {
                true => TYPICAL_NET_RATIO * longest,
                false => net.max(MIN_NET_RATIO * longest),
            },
            longest,
            phases,
        })
    }

    /// Integration error of one phase that a tolerance of the net displacement allows, absolute.
    pub fn span_tolerance(&self, tolerance: f64) -> f64 {
        INTEGRATION_SHARE * tolerance * self.net / self.phases as f64
    }

    /// Relative error of velocities that is small compared with the allowed integration error.
    pub fn velocity_tolerance(&self, tolerance: f64) -> f64 {
        MODEL_SHARE * self.span_tolerance(tolerance) / self.longest
    }
}

/// Whether no body is held or linked to another one.
fn are_free(scene: &Scene) -> bool {
    scene.articulation().joints().is_empty() && !scene.has_held_bodies()
}

/// Relative error of the velocities of a model for a tolerance of the net displacement.
pub(crate) fn velocity_tolerance(scene: &Scene) -> f64 {
    let tolerance = scene.working_tolerance();
    match Prediction::from_scene(scene) {
        Some(prediction) => prediction.velocity_tolerance(tolerance),
        // Forces on many free bodies move them, and no displacements of phases cancel.
        None if scene.bodies().len() > MAX_BODIES && are_free(scene) => 0.1 * tolerance,
        // The net displacement of the planar three-sphere swimmer is 1/100 of that of a phase.
        None => 0.01 * tolerance,
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;

    /// Tolerances of a body that turned in place by whole turns were relative to rounding.
    #[test]
    fn bug_whole_turns_of_a_rotor_counted_as_no_rotation() {
        let longest = |turns: f64| {
            // `T = 8 π μ a³ ω`
            let torque = 8.0 * PI * TAU * turns;
            let text = format!(
                "bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0], \
                 torque = [0, 0, {torque:?}] }}]\ngait.phases = [{{ duration = 1 }}]"
            );
            Prediction::from_scene(&Scene::parse(&text).unwrap())
                .unwrap()
                .longest
        };
        for turns in [0.3, 1.0, 3.0, 7.25] {
            let exact = TAU * turns;
            assert!((longest(turns) - exact).abs() < 1e-12 * exact, "{turns}");
        }
    }
}
