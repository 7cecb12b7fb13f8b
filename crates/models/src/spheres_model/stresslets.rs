//! Stresslets of spheres by multipole expansions.

use microhydro::HydroError;
use microhydro::multipole::{self, SurfaceVelocity};
use nalgebra::{DVector, Vector3};
use rigid::BodyKind;

use super::SpheresModel;
use super::resistances::Resistances;
use crate::error::ModelError;
use crate::hydrodynamics::Configuration;
use crate::stresslets::Stresslets;

impl SpheresModel {
    /// Stresslets of spheres with these generalised velocities.
    ///
    /// `None` for models of point forces, and for spheres that are too many for the expansions.
    ///
    /// Cost: one solve of the expansions.
    ///
    /// # Errors
    /// An iteration that does not converge.
    pub(super) fn stresslets(
        &self,
        configuration: Configuration,
        resistances: &Resistances,
        generalised: &DVector<f64>,
    ) -> Result<Option<Stresslets>, ModelError> {
        let Some(orders) = &resistances.orders else {
            return Ok(None);
        };
        let moving = self.placed(configuration, generalised)?;
        let surface = |sphere: usize, n: &Vector3<f64>| moving.surface_velocity(sphere, n);
        let found = multipole::stresslets(
            &moving.spheres,
            &self.medium,
            orders,
            &moving.velocities,
            (moving.surfaces.as_ref()).map(|_| &surface as &SurfaceVelocity<'_>),
        );
        let found = match found {
            Err(HydroError::TooLarge { .. }) => return Ok(None),
            found => found?,
        };
        let kinds = self.scaled.set.kinds();
        let surfaced: Vec<usize> = (0..kinds.len())
            .filter(|&body| kinds[body] == BodyKind::Rigid)
            .collect();
        let to_scene =
            |scaled: &[_]| Stresslets::to_scene(scaled, &surfaced, kinds.len(), &self.scaled.scale);
        let (stresslets, coarser) = (to_scene(&found.values), to_scene(&found.coarser));
        // Expansions are not corrected: the change of the order is the error.
        let error = stresslets
            .clone()
            .correcting(&coarser, found.tail, 0.0)
            .error;
        Ok(Some(Stresslets {
            error,
            ..stresslets
        }))
    }
}
