//! Observers of a simulation, and callbacks about the progress of a run.

use models::Hydrodynamics;
use scene::{PhaseSpan, Scene};

use crate::error::SwimError;
use crate::integrate::{SpanResult, SpanSolution};
use crate::outcome::Outcome;

/// Callbacks during a simulation, for example to write files or to show progress.
#[allow(unused_variables)]
pub trait Observer {
    /// Whether solutions are shown with their flow, by models that compute it on the way.
    ///
    /// A flow takes the memory of a mesh and a few fields on it as long as it is kept.
    fn wants_flows(&self) -> bool {
        false
    }

    /// Called after every solve with the solution and the model.
    ///
    /// # Errors
    /// Any error ends the simulation.
    fn solved(
        &mut self,
        span: &PhaseSpan,
        solution: &SpanSolution,
        model: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        Ok(())
    }

    /// Called after every phase span with its result, the outcome of all phase spans so far, and
    /// the model in the state in which the next phase span starts, in which it must be left.
    ///
    /// # Errors
    /// Any error ends the simulation.
    fn span_done(
        &mut self,
        span: &PhaseSpan,
        result: &SpanResult,
        so_far: &Outcome,
        model: &mut dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        Ok(())
    }

    /// Called where the motion ends within a phase span, by contact or because it cannot be
    /// computed any further, with the part of the phase span before it and the outcome up to there;
    /// the error follows.
    ///
    /// # Errors
    /// Any error replaces that of the motion.
    fn stopped(
        &mut self,
        span: &PhaseSpan,
        result: &SpanResult,
        so_far: &Outcome,
        model: &mut dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        Ok(())
    }
}

/// An observer that does nothing.
impl Observer for () {}

/// A stroke whose estimated discretisation error exceeds `fem.target`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MissedTarget {
    /// Factor on the element sizes, as the scene key `fem.size_factor`.
    pub size_factor: f64,
    /// Estimated discretisation error, divided by [`Outcome::reference_displacement`].
    pub relative_error: f64,
}

/// Callbacks that inform the caller about the progress of a run.
#[allow(unused_variables)]
pub trait Progress {
    /// Whether the run is to stop; checked after every solve.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// Work that is no solve of the gait: the choice of the model before it, what neglected terms
    /// cost and files after it. `done` of `all` parts are done, in units of their own; `all` is
    /// zero where nothing is counted.
    fn works(&mut self, work: &str, done: f64, all: f64) {}

    /// The factor on the element sizes for `fem.target` has been chosen for the stroke that begins.
    fn chose_size_factor(&mut self, target: f64, size_factor: f64) {}

    /// The stroke is done and its discretisation error exceeds `fem.target`; another one follows
    /// with smaller elements.
    fn missed_target(&mut self, missed: &MissedTarget) {}

    /// The gait is done and its error bar exceeds `allowed`; it is repeated with the factor
    /// `model.tolerance_factor`.
    fn missed_tolerance(&mut self, error: f64, allowed: f64, tolerance_factor: f64) {}

    /// The gait is done without a term of the equations, which is not enough for this reason; it is
    /// repeated with it.
    fn keeps_term(&mut self, reason: &str) {}

    /// A cycle before the gait is done in the search for the periodic state; `remains` is what is
    /// compared with `allowed`, both displacements, and infinite after the first cycles.
    fn searched_cycle(&mut self, cycles: usize, remains: f64, allowed: f64) {}

    /// The gait begins, or continues after `done` phases of an earlier run.
    fn begins(&mut self, scene: &Scene, done: usize) {}

    /// A solve is done.
    fn solved(&mut self, span: &PhaseSpan, solution: &SpanSolution) {}

    /// A phase is done.
    fn span_done(&mut self, span: &PhaseSpan, result: &SpanResult) {}
}

/// No callbacks.
impl Progress for () {}

/// An error if a run is to stop after so many phases of all.
pub(crate) fn check_interruption(
    progress: &dyn Progress,
    phases: usize,
    all: usize,
) -> Result<(), SwimError> {
    match progress.is_interrupted() {
        true => Err(SwimError::Interrupted { phases, all }),
        false => Ok(()),
    }
}
