//! The error of the mesh of a fluid with inertia, by a coarser one that moves beside it.

use models::{DiscretisationError, InstantaneousSolution, Uncertainty};
use rigid::StateVelocity;
use scene::PhaseSpan;

use super::moving_fluid::{FluidState, MovingFluid, TriedStep, other_discretisation};
use crate::error::SwimError;
use crate::kinetic_energy::KineticEnergy;

/// Factor on the element sizes of a coarser mesh in space.
///
/// Errors on it are then two to four times as large: the second order is what is left of the third
/// or fourth where boundary layers and wakes are not resolved.
pub(crate) const COARSER: f64 = 1.4;

/// A fluid and the same on a coarser mesh, which take the same steps.
///
/// The motion is that of the fine mesh minus its estimated error, a share of the difference to the
/// coarse one. Both keep velocities of their own, so that the difference is that of the whole
/// motion, with the errors by new meshes and of boundary layers that begin thinner than an element,
/// which no estimate for one flow sees.
pub(super) struct WithCompanion<'a> {
    fine: Box<dyn MovingFluid + 'a>,
    coarse: Box<dyn MovingFluid + 'a>,
    /// Error of the fine mesh over the difference between both.
    share: f64,
    /// Relative uncertainty of that.
    uncertainty: f64,
}

impl<'a> WithCompanion<'a> {
    /// Of meshes in space whose sizes differ by [`COARSER`]: the share is 1 for the second order
    /// and 0.35 for the fourth.
    pub fn of_space(fine: Box<dyn MovingFluid + 'a>, coarse: Box<dyn MovingFluid + 'a>) -> Self {
        Self {
            fine,
            coarse,
            share: 0.5,
            uncertainty: 2.0,
        }
    }

    /// Of elements in the meridian plane whose orders differ by one, by which errors change by
    /// factors of two to ten.
    pub fn of_meridian_plane(
        fine: Box<dyn MovingFluid + 'a>,
        coarse: Box<dyn MovingFluid + 'a>,
    ) -> Self {
        Self {
            fine,
            coarse,
            share: 0.25,
            uncertainty: 4.0,
        }
    }
}

impl MovingFluid for WithCompanion<'_> {
    fn time(&self) -> f64 {
        self.fine.time()
    }

    fn enter(&mut self, span: &PhaseSpan) {
        self.fine.enter(span);
        self.coarse.enter(span);
    }

    fn start_from_stokes(&mut self, span: &PhaseSpan) -> Result<(), SwimError> {
        self.fine.start_from_stokes(span)?;
        self.coarse.start_from_stokes(span)
    }

    fn restart(&mut self) {
        self.fine.restart();
        self.coarse.restart();
    }

    fn try_step(&mut self, length: f64) -> Result<TriedStep, SwimError> {
        let fine = self.fine.try_step(length)?;
        let coarse = self.coarse.try_step(fine.length)?;
        let difference = &coarse.increment + &(&fine.increment * -1.0);
        let error: StateVelocity = &difference * self.share;
        Ok(TriedStep {
            increment: &fine.increment + &(&error * -1.0),
            mesh_error: Some(error),
            ..fine
        })
    }

    fn solution(&mut self, with_flow: bool) -> Result<InstantaneousSolution, SwimError> {
        let mut fine = self.fine.solution(with_flow)?;
        let coarse = self.coarse.solution(false)?;
        let uncertainty = Uncertainty {
            relative: self.uncertainty,
            ..Uncertainty::default()
        };
        let difference =
            DiscretisationError::between(&coarse.response, &fine.response, uncertainty);
        if let Some(error) = DiscretisationError::combination([(self.share, &difference)]) {
            fine.correct(error);
        }
        fine.seconds += coarse.seconds;
        Ok(fine)
    }

    fn accept(&mut self) -> Result<(), SwimError> {
        self.fine.accept()?;
        self.coarse.accept()
    }

    fn kinetic_energy(&self) -> Result<KineticEnergy, SwimError> {
        let [fine, coarse] = [self.fine.kinetic_energy()?, self.coarse.kinetic_energy()?];
        Ok(fine.corrected(&coarse, self.share, self.uncertainty))
    }

    fn remembered(&mut self) -> Result<FluidState, SwimError> {
        let both = [self.fine.remembered()?, self.coarse.remembered()?];
        Ok(FluidState::WithCompanion(Box::new(both)))
    }

    fn continue_from(&mut self, state: FluidState) -> Result<(), SwimError> {
        let FluidState::WithCompanion(both) = state else {
            return Err(other_discretisation());
        };
        let [fine, coarse] = *both;
        self.fine.continue_from(fine)?;
        self.coarse.continue_from(coarse)
    }
}
