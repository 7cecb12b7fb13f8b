//! What may be done while a simulation goes on.

use models::Hydrodynamics;
use scene::Leg;

use crate::SwimError;
use crate::integrate::{LegResult, LegSolution};
use crate::outcome::Outcome;

/// What may be done while a simulation goes on: write files, show progress.
pub trait Observer {
    /// Sees every solve, with the model that made it; `number` counts over the whole simulation.
    ///
    /// # Errors
    /// Any error ends the simulation.
    fn solved(
        &mut self,
        leg: &Leg,
        solved: &LegSolution,
        model: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        let _ = (leg, solved, model);
        Ok(())
    }

    /// Sees every leg when it is done, everything up to it, and the model in whose hands the next leg is.
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
