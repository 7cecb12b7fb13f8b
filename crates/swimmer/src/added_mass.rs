//! Forces that accelerate the fluid around bodies.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Part of the forces of the bodies on a fluid with inertia which is due to their accelerations, in
/// the units of the scene.
///
/// The added-mass matrix of the configuration times the rates of change of the velocities `(U, ω)`:
/// what the forces would change by at once, if the accelerations did, whatever the viscosity and
/// the flow ([`inertia::added_mass_forces`]). The accelerations are those of the difference formula
/// of the step: after a jump of the velocities, the mean over the first step.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[non_exhaustive]
pub struct AddedMassForces {
    /// Force and torque of each body, the latter about its centre, without their estimated errors
    /// by the mesh.
    pub bodies: Vec<[Vector3<f64>; 2]>,
    /// Uncertainty of the forces and of the torques by the mesh, in space without the errors of
    /// steps; none where it is not estimated.
    pub mesh_error: Option<[f64; 2]>,
}

impl AddedMassForces {
    /// Forces without an estimate of their errors.
    pub(crate) fn new(bodies: Vec<[Vector3<f64>; 2]>) -> Self {
        Self {
            bodies,
            mesh_error: None,
        }
    }

    /// These forces minus `share` of the differences of those on a coarser mesh to them, with an
    /// uncertainty relative to that.
    pub(crate) fn corrected(&self, coarse: &Self, share: f64, uncertainty: f64) -> Self {
        let mut largest = [0.0_f64; 2];
        let body = |(fine, coarse): (&[Vector3<f64>; 2], &[Vector3<f64>; 2])| {
            [0, 1].map(|part| {
                let error = share * (coarse[part] - fine[part]);
                largest[part] = largest[part].max(uncertainty * error.norm());
                fine[part] - error
            })
        };
        let bodies = self.bodies.iter().zip(&coarse.bodies).map(body);
        Self {
            bodies: bodies.collect(),
            mesh_error: Some(largest),
        }
    }
}
