//! Observers of a simulation.

use models::Hydrodynamics;
use scene::Leg;

use crate::error::SwimError;
use crate::integrate::{LegResult, LegSolution};
use crate::outcome::Outcome;

/// Callbacks during a simulation, for example to write files or to show progress.
pub trait Observer {
    /// Called after every solve with the solution and the model.
    ///
    /// # Errors
    /// Any error ends the simulation.
    fn solved(
        &mut self,
        leg: &Leg,
        solution: &LegSolution,
        model: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        let _ = (leg, solution, model);
        Ok(())
    }

    /// Called after every leg with its result, the outcome of all legs so far, and the model in the
    /// state in which the next leg starts.
    ///
    /// # Errors
    /// Any error ends the simulation.
    fn leg_done(
        &mut self,
        leg: &Leg,
        result: &LegResult,
        so_far: &Outcome,
        model: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        let _ = (leg, result, so_far, model);
        Ok(())
    }
}

/// An observer that does nothing.
impl Observer for () {}
