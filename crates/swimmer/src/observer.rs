//! Observers of a simulation.

use models::Hydrodynamics;
use scene::PhaseSpan;

use crate::error::SwimError;
use crate::integrate::{SpanResult, SpanSolution};
use crate::outcome::Outcome;

/// Callbacks during a simulation, for example to write files or to show progress.
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
        let _ = (span, solution, model);
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
        let _ = (span, result, so_far, model);
        Ok(())
    }
}

/// An observer that does nothing.
impl Observer for () {}
