//! Drive of an articulated set: constraints of its joints and external loads on its bodies.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::damping::Damping;
use crate::error::check_length;
use crate::placement::is_finite;
use crate::{Articulation, BodyKind, Constraints, RigidError};

/// Drive of an articulated set in one configuration: rates of its joints and external loads.
#[derive(Clone, Debug)]
pub struct Drive<'a> {
    /// The bodies and their joints.
    pub set: &'a Articulation,
    /// The constraints of the joints in this configuration.
    pub constraints: &'a Constraints,
    /// External force and torque on each body; the torque on a point is ignored.
    pub loads: &'a [ExternalLoad],
}

/// External force and torque that act on a body.
///
/// A body without joints transmits them to the fluid: they then equal the force and torque of the
/// body on the fluid, the opposite of the force and torque of the fluid on the body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ExternalLoad {
    /// Force.
    pub force: Vector3<f64>,
    /// Torque about the centre of the body.
    pub torque: Vector3<f64>,
}

impl Drive<'_> {
    /// External loads and forces on passive joints as a vector conjugate to the generalised
    /// velocities.
    ///
    /// # Errors
    /// A list of loads of the wrong length, a load that is not finite, constraints of another set.
    pub fn generalised_loads(&self) -> Result<DVector<f64>, RigidError> {
        self.check()?;
        let layout = &self.constraints.layout;
        let mut loads = DVector::zeros(layout.len());
        for (body, load) in self.loads.iter().enumerate() {
            let first = layout.bodies()[body];
            loads.fixed_rows_mut::<3>(first).copy_from(&load.force);
            if self.set.kinds()[body] == BodyKind::Rigid {
                loads.fixed_rows_mut::<3>(first + 3).copy_from(&load.torque);
            }
        }
        for (column, force) in layout.joints().zip(&self.constraints.joint_forces) {
            loads[column] = *force;
        }
        Ok(loads)
    }

    /// `D q` for generalised velocities `q`: the forces of dashpots and of
    /// [`Constraints::body_damping`] are `-D q`.
    ///
    /// # Errors
    /// A `q` of the wrong length.
    pub fn damping_times(&self, q: &DVector<f64>) -> Result<DVector<f64>, RigidError> {
        check_length(
            "generalised velocities",
            q.len(),
            self.constraints.layout.len(),
        )?;
        Ok(self.damping().times(q))
    }

    /// `tests^T D columns`, with one row of each per generalised velocity.
    ///
    /// # Errors
    /// Matrices of the wrong size.
    pub fn damping_projected(
        &self,
        tests: &DMatrix<f64>,
        columns: &DMatrix<f64>,
    ) -> Result<DMatrix<f64>, RigidError> {
        for rows in [tests.nrows(), columns.nrows()] {
            check_length(
                "generalised velocities",
                rows,
                self.constraints.layout.len(),
            )?;
        }
        Ok(self.damping().projected(tests, columns))
    }

    pub(crate) fn damping(&self) -> Damping {
        Damping::new(
            &self.constraints.layout,
            &self.constraints.joint_damping,
            &self.constraints.body_damping,
        )
    }

    /// Refuses constraints of another set, and loads that do not fit the bodies.
    pub(crate) fn check(&self) -> Result<(), RigidError> {
        if self.constraints.layout != self.set.velocity_layout() {
            return Err(RigidError::OtherSet);
        }
        self.constraints.check()?;
        let bodies = self.set.kinds().len();
        check_length("loads on the bodies", self.loads.len(), bodies)?;
        let mut loads = self.loads.iter().flat_map(|load| [load.force, load.torque]);
        if !loads.all(|load| is_finite(&load)) {
            return Err(RigidError::NotFinite {
                what: "the load on a body",
            });
        }
        Ok(())
    }
}
