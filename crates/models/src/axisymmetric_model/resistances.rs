//! The resistances of a configuration.

use super::AxisymmetricModel;
use crate::axial_resistance::{Resistances, best_found};
use crate::error::ModelError;
use crate::hydrodynamics::Configuration;

impl AxisymmetricModel {
    /// The resistances to the motions that the scene has, to a relative tolerance.
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
            None => best_found(self.solver.axial(&bodies, self.surroundings, tolerance))?,
        };
        let spin = match self.has_swirl {
            true => {
                let spin = self.solver.spin(&bodies, self.surroundings, tolerance);
                Some(best_found(spin)?)
            }
            false => None,
        };
        Ok(Resistances {
            axial,
            surfaces,
            spin,
        })
    }
}
