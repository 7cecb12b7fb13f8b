//! Loads of the joints on bodies: multipliers of the constraints, in every formulation.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::constraints::{HeldRows, JointRows};
use crate::drive::Damping;
use crate::error::check_length;
use crate::{
    Constraints, Drive, ExternalLoad, JointLoad, NullSpace, Reduction, RigidError, SymmetryPlanes,
};

/// Data for the loads `λ` of the joints: `C^T λ` balances the fluid's forces and the external
/// loads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct JointLoads {
    /// Independent rows of `C`, gauge rows below them.
    rows: DMatrix<f64>,
    /// Indices of the independent rows of `C`; the other rows are redundant and carry no load.
    independent: Vec<usize>,
    /// Number of rows of `C`.
    constraints: usize,
    /// External loads, conjugate to the generalised velocities.
    external: DVector<f64>,
    /// Generalised velocities of bodies with surfaces.
    surface_rows: Vec<usize>,
    /// Velocities of bodies with surfaces that the joints allow, one column per dof.
    surface_basis: DMatrix<f64>,
    /// Velocities of bodies, frames and joints that the joints allow, one column per dof.
    basis: DMatrix<f64>,
    /// Resistances in addition to that of the fluid.
    damping: Damping,
    /// Rows of each joint.
    joint_rows: Vec<JointRows>,
    /// Rows of the held bodies.
    held_rows: Vec<HeldRows>,
}

/// Power of the loads on a motion of unit size, relative to the loads, up to which it is rounding
/// of the elimination.
const MAX_UNRESISTED_POWER: f64 = 1e-9;

impl Drive<'_> {
    /// The velocities that joints and symmetry planes allow, and data for the loads of the joints.
    ///
    /// Only [`NullSpace::offset`] depends on the rates of the joints.
    ///
    /// # Errors
    /// Joints that contradict each other, loads that are not symmetric about the planes, not finite
    /// or of the wrong number, loads on motions that move no surface, constraints of another set.
    pub(crate) fn reduced(
        &self,
        symmetry_planes: SymmetryPlanes,
    ) -> Result<(NullSpace, JointLoads), RigidError> {
        self.check()?;
        let constraints = Constraints::with_symmetry(self, symmetry_planes)?;
        let Reduction {
            all, surface_basis, ..
        } = Reduction::new(self.set, &constraints)?;
        let external = self.generalised_loads()?;
        let power = all.unresisted.tr_mul(&external);
        if power.amax() > MAX_UNRESISTED_POWER * external.amax() {
            return Err(RigidError::Unresisted {
                power: power.amax(),
            });
        }
        let loads = JointLoads {
            rows: all.constraint_rows(&constraints),
            independent: all.independent.clone(),
            constraints: constraints.matrix.nrows(),
            external,
            surface_rows: self.set.surface_velocities(),
            surface_basis,
            basis: all.basis.clone(),
            damping: self.damping(),
            joint_rows: constraints.joint_rows.clone(),
            held_rows: constraints.held_rows.clone(),
        };
        Ok((all, loads))
    }

    /// Loads of the joints that balance given forces `(F, T)` of the rigid bodies on the fluid.
    ///
    /// For flow models that provide resistances only: one load per joint of the set, those of
    /// [`FlowSolution::joint_load`](crate::FlowSolution::joint_load). `velocities` are all
    /// generalised velocities, which dashpots depend on.
    ///
    /// # Errors
    /// Joints that contradict each other, lists of the wrong length.
    pub fn joint_loads(
        &self,
        forces: &DVector<f64>,
        velocities: &DVector<f64>,
    ) -> Result<Vec<JointLoad>, RigidError> {
        let (loads, rows) = self.balancing(forces, velocities)?;
        (0..loads.joint_rows.len())
            .map(|joint| JointRows::load_of(&loads.joint_rows, &rows, joint))
            .collect()
    }

    /// Loads that hold bodies, by whatever imposes their velocities: one per held body, with its
    /// index.
    ///
    /// Arguments as in [`Drive::joint_loads`], the loads of
    /// [`FlowSolution::holding_loads`](crate::FlowSolution::holding_loads). The part that is not
    /// held is zero. Where joints hold two held bodies to each other, the loads of these joints are
    /// not determined and count as zero.
    ///
    /// # Errors
    /// Joints that contradict each other, lists of the wrong length.
    pub fn holding_loads(
        &self,
        forces: &DVector<f64>,
        velocities: &DVector<f64>,
    ) -> Result<Vec<(usize, ExternalLoad)>, RigidError> {
        if self.constraints.held_rows.is_empty() {
            return Ok(Vec::new());
        }
        let (loads, rows) = self.balancing(forces, velocities)?;
        Ok(HeldRows::loads_of(&loads.held_rows, &rows))
    }

    /// The loads of all rows that balance given forces.
    fn balancing(
        &self,
        forces: &DVector<f64>,
        velocities: &DVector<f64>,
    ) -> Result<(JointLoads, DVector<f64>), RigidError> {
        check_length(
            "generalised velocities",
            velocities.len(),
            self.constraints.layout.len(),
        )?;
        check_length(
            "forces and torques of the rigid bodies",
            forces.len(),
            self.set.surface_velocities().len(),
        )?;
        let (_, loads) = self.reduced(SymmetryPlanes::default())?;
        let rows = loads.balancing(forces, velocities)?;
        Ok((loads, rows))
    }
}

impl HeldRows {
    /// The loads that hold bodies, by the rows of all of them, from the loads of all rows.
    pub fn loads_of(all: &[Self], loads: &DVector<f64>) -> Vec<(usize, ExternalLoad)> {
        let mut of_bodies: Vec<(usize, ExternalLoad)> = Vec::new();
        for rows in all {
            let Some(part) = loads.as_slice().get(rows.first..rows.first + 3) else {
                continue;
            };
            if of_bodies.last().is_none_or(|(body, _)| *body != rows.body) {
                of_bodies.push((rows.body, ExternalLoad::default()));
            }
            if let Some((_, load)) = of_bodies.last_mut() {
                let of_part = match rows.is_rotation {
                    true => &mut load.torque,
                    false => &mut load.force,
                };
                *of_part = Vector3::from_column_slice(part);
            }
        }
        of_bodies
    }
}

impl JointLoads {
    /// Independent rows of `C`, gauge rows below them.
    pub(crate) fn rows(&self) -> &DMatrix<f64> {
        &self.rows
    }

    /// Rows of each joint.
    pub(crate) fn joint_rows(&self) -> &[JointRows] {
        &self.joint_rows
    }

    /// Rows of the held bodies.
    pub(crate) fn held_rows(&self) -> &[HeldRows] {
        &self.held_rows
    }

    /// External loads, conjugate to the generalised velocities.
    pub(crate) fn external(&self) -> &DVector<f64> {
        &self.external
    }

    /// Loads from the multipliers `α` of the independent rows: `M q + C^T α = F`, so `λ = -α`.
    pub(crate) fn of_multipliers(&self, multipliers: &[f64]) -> DVector<f64> {
        self.of_independent(multipliers.iter().map(|alpha| -alpha))
    }

    /// Loads that balance the forces `(F, T)` of the bodies on the fluid at velocities `q`.
    ///
    /// `C^T λ = forces + damping q - external`. The rows are independent, so the least-squares
    /// solution is unique. Its residual is the residual of the force balances of the motions that
    /// the joints allow.
    ///
    /// # Errors
    /// [`RigidError::DependentConstraints`] for rows that are linearly dependent to rounding.
    pub(crate) fn balancing(
        &self,
        forces: &DVector<f64>,
        velocities: &DVector<f64>,
    ) -> Result<DVector<f64>, RigidError> {
        let others = self.damping.times(velocities) - &self.external;
        let multipliers = self.multipliers(forces, others)?;
        Ok(self.of_independent(multipliers.iter().copied()))
    }

    /// Change of the loads for changes of the forces `(F, T)` and of all velocities, and the forces
    /// that it balances.
    ///
    /// The external loads do not change. The forces returned do no work on motions that the joints
    /// allow, but for that of the dashpots: `f - S (S^T S)^-1 (S^T f + B^T D q)` with the basis `B`
    /// of all velocities, `S` its rows of surfaces.
    ///
    /// # Errors
    /// Those of [`JointLoads::balancing`].
    pub(crate) fn change(
        &self,
        forces: &DVector<f64>,
        velocities: &DVector<f64>,
    ) -> Result<(DVector<f64>, DVector<f64>), RigidError> {
        let basis = &self.surface_basis;
        let gram = (basis.tr_mul(basis))
            .cholesky()
            .ok_or(RigidError::DependentConstraints)?;
        let of_dashpots = self.damping.times(velocities);
        let work = basis.tr_mul(forces) + self.basis.tr_mul(&of_dashpots);
        let balanced = forces - basis * gram.solve(&work);
        let multipliers = self.multipliers(&balanced, of_dashpots)?;
        Ok((self.of_independent(multipliers.iter().copied()), balanced))
    }

    /// Loads of all rows from those of the independent ones.
    fn of_independent(&self, multipliers: impl Iterator<Item = f64>) -> DVector<f64> {
        let mut loads = DVector::zeros(self.constraints);
        for (&row, load) in self.independent.iter().zip(multipliers) {
            loads[row] = load;
        }
        loads
    }

    /// Least-squares solution of `C^T λ = forces + others`, gauge rows included.
    fn multipliers(
        &self,
        forces: &DVector<f64>,
        others: DVector<f64>,
    ) -> Result<DVector<f64>, RigidError> {
        let mut unbalanced = others;
        for (&row, force) in self.surface_rows.iter().zip(forces.iter()) {
            unbalanced[row] += force;
        }
        let normal = (&self.rows * self.rows.transpose())
            .cholesky()
            .ok_or(RigidError::DependentConstraints)?;
        Ok(normal.solve(&(&self.rows * unbalanced)))
    }
}
