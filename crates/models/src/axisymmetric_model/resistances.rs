//! The resistances of a configuration.

use super::AxisymmetricModel;
use crate::axial_resistance::Resistances;
use crate::error::ModelError;
use crate::hydrodynamics::Configuration;

impl AxisymmetricModel {
    /// The resistances to the motions that the scene has, to a relative tolerance.
    ///
    /// If the tolerance is out of reach, those with the smallest error: the error bars of the
    /// solution are those of the resistance, and whoever integrates a stroke decides whether they
    /// are small enough.
    ///
    /// # Errors
    /// Bodies that left the axis; failures of the solver.
    pub(super) fn resistances(
        &mut self,
        configuration: Configuration,
        tolerance: f64,
    ) -> Result<Resistances, ModelError> {
        let bodies = self.on_axis(configuration)?;
        let surfaces = match self.scaled.scene.has_surface_velocity() {
            true => Some(
                self.solver
                    .surfaces(&bodies, self.surroundings, tolerance)?,
            ),
            false => None,
        };
        let axial = match &surfaces {
            Some(surfaces) => surfaces.power().clone(),
            None => self
                .solver
                .axial_best(&bodies, self.surroundings, tolerance)?,
        };
        let spin = match self.has_swirl {
            true => Some(
                self.solver
                    .spin_best(&bodies, self.surroundings, tolerance)?,
            ),
            false => None,
        };
        Ok(Resistances {
            axial,
            surfaces,
            spin,
        })
    }
}
