//! Stresslets of bodies of revolution on one axis.

use axisymmetric::{BodyVelocity, SurfaceMode, SurfaceResistance};
use nalgebra::{DMatrix, DVector, Matrix3};

use super::axial_surfaces::{AxialResistances, AxialSurfaces};
use super::{AxisymmetricModel, UNCERTAINTY};
use crate::error::ModelError;
use crate::query::Configuration;
use crate::response::BodySolution;
use crate::solution::{InstantaneousSolution, Stresslets};

/// Relative uncertainty of stresslets that no order of the elements removes.
///
/// In extensions, a sphere and a prolate spheroid of 2:1 have errors of 4.1e-8 and 2.9e-8 at any
/// accuracy that is requested; slip has none.
const EXTENSION_UNCERTAINTY: f64 = 1e-7;

impl AxisymmetricModel {
    /// Adds the stresslets to solutions for one configuration.
    ///
    /// They need the resistance to an extension of the surfaces, which is computed for them if the
    /// surfaces are rigid. Where its elements do not converge, the solutions have none.
    ///
    /// # Errors
    /// Bodies that left the axis.
    pub(super) fn add_stresslets(
        &mut self,
        configuration: Configuration,
        resistances: &AxialResistances,
        tolerance: f64,
        solutions: &mut [InstantaneousSolution],
    ) -> Result<(), ModelError> {
        let bodies = self.on_axis(configuration)?;
        let modes = match &resistances.surfaces {
            Some(modes) => modes.clone(),
            None => match (self.solver).surfaces(&bodies, self.surroundings, tolerance) {
                Ok(modes) => modes,
                Err(_) => return Ok(()),
            },
        };
        let surfaces = AxialSurfaces::new(&self.scaled, configuration, resistances, &self.axis)?;
        let surfaces = surfaces.as_ref();
        for solution in solutions {
            let power = modes.power();
            let of = |bodies: &[BodySolution], power: &DMatrix<f64>| {
                self.stresslets_of(&self.body_velocities(bodies, surfaces), &modes, power)
            };
            let computed = of(&solution.uncorrected().bodies, power.matrix());
            let corrected = of(&solution.bodies, &power.extrapolated());
            let mut stresslets = corrected.correcting(&computed, UNCERTAINTY, 0.0);
            let remaining = EXTENSION_UNCERTAINTY * stresslets.largest();
            stresslets.error = stresslets.error.map(|error| error + remaining);
            solution.stresslets = Some(stresslets);
        }
        Ok(())
    }

    /// Stresslets `s (k k^T - I / 3)` of bodies with these velocities, by a resistance `power`.
    ///
    /// The power in the extension `k k^T x - (I - k k^T) x / 2` is that of the forces on the fluid.
    /// The strain of the surface adds `∮ u · 2 E n dS` in it.
    fn stresslets_of(
        &self,
        velocities: &[BodyVelocity],
        modes: &SurfaceResistance,
        power: &DMatrix<f64>,
    ) -> Stresslets {
        let mut amplitudes = DVector::zeros(power.nrows());
        for (body, velocity) in velocities.iter().enumerate() {
            amplitudes[body] = velocity.axial;
            let first = modes.row(body, SurfaceMode::FirstSlip);
            for (mode, amplitude) in velocity.modes.iter().enumerate() {
                amplitudes[first + mode] = *amplitude;
            }
        }
        let shape = self.axis * self.axis.transpose() - Matrix3::identity() / 3.0;
        let stresslets: Vec<Matrix3<f64>> = (0..velocities.len())
            .map(|body| {
                let row = modes.row(body, SurfaceMode::Extension);
                let of_forces = power.column(row).dot(&amplitudes);
                let of_strain = modes.powers_in_flows().column(row).dot(&amplitudes);
                shape * -(of_forces + of_strain)
            })
            .collect();
        self.scaled.stresslets_to_scene(&stresslets)
    }
}
