//! What drives an articulated set: constraints of its links and loads on its bodies.

use nalgebra::{DVector, Vector3};

use crate::articulation::check_length;
use crate::{Articulation, BodyKind, Constraints, RigidError, SymmetryPlanes};

/// What drives an articulated set at one instant.
#[derive(Clone, Debug)]
pub struct Drive<'a> {
    /// The bodies and their links.
    pub set: &'a Articulation,
    /// The constraints of the links at this instant.
    pub constraints: &'a Constraints,
    /// External force and torque on each body (points take a force only).
    pub loads: &'a [ExternalLoad],
}

/// External force and torque on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExternalLoad {
    /// Force.
    pub force: Vector3<f64>,
    /// Torque about the body's centre.
    pub torque: Vector3<f64>,
}

impl Drive<'_> {
    /// External loads as work-conjugate of the generalised velocities.
    ///
    /// # Errors
    /// A list of loads of the wrong length.
    pub fn generalised_loads(&self) -> Result<DVector<f64>, RigidError> {
        check_length(
            "loads on the bodies",
            self.loads.len(),
            self.set.kinds().len(),
        )?;
        let layout = &self.constraints.layout;
        let mut loads = DVector::zeros(layout.len());
        for (body, load) in self.loads.iter().enumerate() {
            let first = layout.body(body);
            loads.fixed_rows_mut::<3>(first).copy_from(&load.force);
            if self.set.kinds()[body] == BodyKind::Rigid {
                loads.fixed_rows_mut::<3>(first + 3).copy_from(&load.torque);
            }
        }
        Ok(loads)
    }

    /// The loads of the links that balance the forces `(F, T)` of the rigid bodies on the fluid, as [`FlowSolution::link_loads`](crate::FlowSolution::link_loads):
    /// for models of the fluid that know resistances only.
    ///
    /// # Errors
    /// Links that contradict each other, lists of the wrong length.
    pub fn link_loads(&self, forces: &DVector<f64>) -> Result<DVector<f64>, RigidError> {
        check_length(
            "forces and torques of the rigid bodies",
            forces.len(),
            self.set.surface_velocities().len(),
        )?;
        self.reduced(SymmetryPlanes::default())?.1.balancing(forces)
    }
}
