//! Velocities and forces of linked bodies from their grand resistance.

use nalgebra::{DMatrix, DVector, Vector3};
use rigid::{Articulation, BodyKind, Constraints, Drive, ExternalLoad, Reduction};

use crate::error::ModelError;
use crate::scale::Scale;
use crate::solution::BodySolution;

/// A solved instant in units of the flow.
#[derive(Clone)]
pub(crate) struct MobilitySolution {
    /// All generalised velocities.
    pub generalised: DVector<f64>,
    /// Forces and torques of the bodies with surfaces on the fluid.
    pub forces: DVector<f64>,
    /// What is left of the balance of forces, relative to the forces.
    pub residual: f64,
}

impl MobilitySolution {
    /// Solves $S^T R S v = S^T (F - R W)$: the balance of all motions that the links leave free (formulation P-tilde).
    ///
    /// # Errors
    /// Links that contradict each other, or a resistance that is not positive definite on the free motions.
    pub fn new(
        resistance: &DMatrix<f64>,
        set: &Articulation,
        constraints: &Constraints,
        loads: &[ExternalLoad],
    ) -> Result<Self, ModelError> {
        let reduction = Reduction::of(set, constraints)?;
        let drive = Drive {
            set,
            constraints,
            loads,
        };
        let (s, w) = (&reduction.surface_basis, &reduction.surface_offset);
        let right =
            reduction.all.basis.tr_mul(&drive.generalised_loads()?) - s.tr_mul(&(resistance * w));
        let matrix = s.tr_mul(&(resistance * s));
        let unknowns = matrix
            .clone()
            .cholesky()
            .ok_or_else(|| {
                let what = "resistance of the motions that the links leave free";
                ModelError::not_positive_definite(what, &matrix)
            })?
            .solve(&right);
        let scale = right.amax();
        let left = (&matrix * &unknowns - &right).amax();
        let generalised = reduction.velocities(&unknowns);
        let surfaces = generalised.select_rows(&set.surface_velocities());
        Ok(Self {
            forces: resistance * surfaces,
            generalised,
            residual: if scale > 0.0 { left / scale } else { 0.0 },
        })
    }

    /// The largest difference of a body's velocity from another answer.
    pub fn fastest_difference(&self, other: &Self, set: &Articulation) -> f64 {
        let layout = set.velocity_layout();
        (0..set.kinds().len())
            .map(|body| {
                let velocity = |solution: &Self| vector(&solution.generalised, layout.body(body));
                (velocity(self) - velocity(other)).norm()
            })
            .fold(0.0, f64::max)
    }

    /// Motion and load of every body in the scene's units.
    ///
    /// # Errors
    /// None for answers of the set.
    pub fn bodies(
        &self,
        set: &Articulation,
        scale: &Scale,
    ) -> Result<Vec<BodySolution>, ModelError> {
        let layout = set.velocity_layout();
        let spins = set.state_velocity(self.generalised.as_slice())?.spins;
        let mut surfaces = 0..;
        Ok((0..set.kinds().len())
            .map(|body| {
                let mut entry = BodySolution {
                    velocity: scale.velocity_back(vector(&self.generalised, layout.body(body))),
                    angular_velocity: spins[body],
                    ..BodySolution::default()
                };
                if set.kinds()[body] == BodyKind::Rigid
                    && let Some(number) = surfaces.next()
                {
                    entry.force = scale.force_back(vector(&self.forces, 6 * number));
                    entry.torque = scale.torque_back(vector(&self.forces, 6 * number + 3));
                }
                entry
            })
            .collect())
    }

    /// The force of each link on its body in the scene's units.
    ///
    /// # Errors
    /// Links that contradict each other.
    pub fn link_forces(
        &self,
        set: &Articulation,
        constraints: &Constraints,
        loads: &[ExternalLoad],
        scale: &Scale,
    ) -> Result<Vec<Vector3<f64>>, ModelError> {
        let drive = Drive {
            set,
            constraints,
            loads,
        };
        let loads = drive.link_loads(&self.forces)?;
        Ok((0..set.links().len())
            .map(|link| scale.force_back(vector(&loads, 3 * link)))
            .collect())
    }
}

fn vector(list: &DVector<f64>, first: usize) -> Vector3<f64> {
    list.fixed_rows::<3>(first).into_owned()
}
