//! Drive of an articulated set: rates and dashpots of its joints, external loads on its bodies.

use nalgebra::{DMatrix, DVector, Matrix6, Vector3};

use crate::error::{check_finite, check_length};
use crate::{Articulation, BodyKind, Constraints, RigidError, VelocityLayout};

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
    /// External loads, forces on passive joints and random loads as a vector conjugate to the
    /// generalised velocities.
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
        if let Some(random) = &self.constraints.random_loads {
            loads += random;
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
        let loads = self.loads.iter();
        let loads = loads.flat_map(|load| load.force.iter().chain(&load.torque));
        check_finite("the load on a body", loads)
    }
}

/// Resistances in addition to that of the fluid: dashpots of joints, inertia of a time step.
///
/// A symmetric matrix `D` over all generalised velocities `q`, block-diagonal: the forces `-D q`
/// act in addition to the external loads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Damping {
    /// Velocities of passive joints, with the coefficients of their dashpots.
    joints: Vec<(usize, f64)>,
    /// First velocities of bodies, with their blocks.
    bodies: Vec<(usize, Matrix6<f64>)>,
}

impl Damping {
    pub fn new(layout: &VelocityLayout, joints: &[f64], bodies: &[(usize, Matrix6<f64>)]) -> Self {
        let joints = layout.joints().zip(joints.iter().copied());
        Self {
            joints: joints
                .filter(|(_, coefficient)| *coefficient != 0.0)
                .collect(),
            bodies: (bodies.iter())
                .filter_map(|(body, block)| Some((layout.body(*body)?, *block)))
                .collect(),
        }
    }

    /// `D q`.
    pub fn times(&self, q: &DVector<f64>) -> DVector<f64> {
        let mut product = DVector::zeros(q.len());
        for &(row, coefficient) in &self.joints {
            product[row] += coefficient * q[row];
        }
        for (first, block) in &self.bodies {
            let part = block * q.fixed_rows::<6>(*first);
            let mut rows = product.fixed_rows_mut::<6>(*first);
            rows += part;
        }
        product
    }

    /// `tests^T D columns`; zero without entries.
    pub fn projected(&self, tests: &DMatrix<f64>, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(tests.ncols(), columns.ncols());
        for &(row, coefficient) in &self.joints {
            sum += coefficient * tests.row(row).transpose() * columns.row(row);
        }
        for (first, block) in &self.bodies {
            let [left, right] = [tests, columns].map(|m| m.fixed_rows::<6>(*first));
            sum += left.transpose() * (block * right);
        }
        sum
    }
}
