//! How a run tells its caller what it does.

use scene::{PhaseSpan, Scene};

use crate::integrate::{SpanResult, SpanSolution};
use crate::planning::MissedTarget;

/// Callbacks that inform the caller about the progress of a run.
pub trait Progress {
    /// Whether the run is to stop; checked after every solve.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// The factor on the element sizes for `fem.target` has been chosen for the stroke that begins.
    fn chose_size_factor(&mut self, target: f64, size_factor: f64) {
        let _ = (target, size_factor);
    }

    /// The stroke is done and its discretisation error exceeds `fem.target`; another one follows
    /// with smaller elements.
    fn missed_target(&mut self, missed: &MissedTarget) {
        let _ = missed;
    }

    /// The gait begins, or continues after `done` phases of an earlier run.
    fn begins(&mut self, scene: &Scene, done: usize) {
        let _ = (scene, done);
    }

    /// A solve is done.
    fn solved(&mut self, span: &PhaseSpan, solution: &SpanSolution) {
        let _ = (span, solution);
    }

    /// A phase is done.
    fn span_done(&mut self, span: &PhaseSpan, result: &SpanResult) {
        let _ = (span, result);
    }
}

/// No callbacks.
impl Progress for () {}
