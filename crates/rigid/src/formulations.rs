//! Formulations of the constraints: P, P-tilde, Lagrange multipliers and direct rows.

use nalgebra::{DMatrix, DVector};

use crate::constrained::Border;
use crate::{Constrained, Constraints, Drive, Reduction, RigidError, RigidFluid};

/// A way to impose the constraints of joints on the flow around rigid bodies.
pub trait Formulation: Sync {
    /// Name for reports and scene files.
    fn name(&self) -> &'static str;

    /// Builds the linear system for one configuration.
    ///
    /// # Errors
    /// Constraints that contradict each other, a fluid in which some velocity is undetermined, or
    /// sizes that do not fit.
    fn constrain(&self, fluid: RigidFluid, drive: &Drive) -> Result<Constrained, RigidError>;
}

/// The operator P of Berti et al. (2021), equation (13): `u = P (u_I, U, ω)`.
///
/// Bodies move independently of each other. With symmetry planes, only their symmetric motions are
/// dofs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Independent;

impl Formulation for Independent {
    fn name(&self) -> &'static str {
        "p"
    }

    fn constrain(&self, fluid: RigidFluid, drive: &Drive) -> Result<Constrained, RigidError> {
        if let Some(joint) = drive.set.joints().first() {
            return Err(RigidError::JointWithoutConstraint {
                joint: joint.name.clone(),
            });
        }
        if let Some(body) = drive.set.held_bodies().next() {
            return Err(RigidError::HeldWithoutConstraint { body });
        }
        let loads = drive.generalised_loads()?;
        let velocities = drive.constraints.layout.len();
        let columns = match fluid.symmetry_planes() {
            planes if planes.is_empty() => DMatrix::identity(velocities, velocities),
            planes => {
                let constraints = Constraints::with_symmetry(drive, planes)?;
                Reduction::new(drive.set, &constraints)?.all.basis
            }
        };
        let border = Border::new(columns, DVector::zeros(velocities));
        Constrained::build(fluid, border, drive, &loads)
    }
}

/// The operator P-tilde of Berti et al. (2021), equations (19)-(22): body velocities `U = S v + W`.
///
/// `S` is a basis of the null space of the joints' constraints and `W` a particular solution. The
/// border has one column per independent motion (6 for a swimmer with clamped arms), and the
/// system stays symmetric.
#[derive(Clone, Copy, Debug, Default)]
pub struct Eliminated;

impl Formulation for Eliminated {
    fn name(&self) -> &'static str {
        "p-tilde"
    }

    fn constrain(&self, fluid: RigidFluid, drive: &Drive) -> Result<Constrained, RigidError> {
        let (all, joint_loads) = drive.reduced(fluid.symmetry_planes())?;
        let loads = joint_loads.external().clone();
        let border = Border {
            joint_loads: Some(joint_loads),
            ..Border::new(all.basis, all.offset)
        };
        Constrained::build(fluid, border, drive, &loads)
    }
}

/// Lagrange multipliers of Berti et al. (2021), equations (16)-(18).
///
/// `M q + ... + C^T α = F`, `C q = w`.
///
/// The border contains all velocities, then one multiplier for each independent constraint
/// (redundant ones would make the system singular). `-C^T α` are the loads of the joints on bodies
/// ([`FlowSolution::joint_loads`](crate::FlowSolution::joint_loads)). The system is symmetric with
/// an indefinite border: multigrid solves it exactly on the coarsest level, where it is dense.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lagrange;

impl Formulation for Lagrange {
    fn name(&self) -> &'static str {
        "lagrange"
    }

    fn constrain(&self, fluid: RigidFluid, drive: &Drive) -> Result<Constrained, RigidError> {
        let (all, joint_loads) = drive.reduced(fluid.symmetry_planes())?;
        let rows = joint_loads.rows();
        let (velocities, multipliers) = (rows.ncols(), rows.nrows());
        let size = velocities + multipliers;
        let mut constraints = DMatrix::zeros(size, size);
        constraints
            .view_mut((velocities, 0), rows.shape())
            .copy_from(rows);
        constraints
            .view_mut((0, velocities), (velocities, multipliers))
            .copy_from(&rows.transpose());
        let loads = joint_loads.external().clone();
        let border = Border {
            constraints: Some(constraints),
            joint_loads: Some(joint_loads),
            first_multiplier: Some(velocities),
            ..Border::new(DMatrix::identity(velocities, size), all.offset)
        };
        Constrained::build(fluid, border, drive, &loads)
    }
}

/// Row substitution of Berti et al. (2021), equation (23): `C q = w` replaces rows of forces.
///
/// Every velocity stays a dof. The remaining force rows are the force balances of the motions that
/// the joints allow, `S^T (force rows) = S^T F`: the *total* force and torque of each linkage.
/// (Equation (23) as printed keeps the force row of the reference body alone, so that the forces on
/// the other bodies would pull the swimmer.) The system is not symmetric.
#[derive(Clone, Copy, Debug, Default)]
pub struct DirectRows;

impl Formulation for DirectRows {
    fn name(&self) -> &'static str {
        "direct-row"
    }

    fn constrain(&self, fluid: RigidFluid, drive: &Drive) -> Result<Constrained, RigidError> {
        let (all, joint_loads) = drive.reduced(fluid.symmetry_planes())?;
        let linked = joint_loads.rows();
        let (velocities, balances) = all.basis.shape();
        let mut rows = DMatrix::zeros(velocities, velocities);
        rows.columns_mut(0, balances).copy_from(&all.basis);
        let mut constraints = DMatrix::zeros(velocities, velocities);
        constraints
            .rows_mut(balances, linked.nrows())
            .copy_from(linked);
        let loads = joint_loads.external().clone();
        let border = Border {
            rows: Some(rows),
            constraints: Some(constraints),
            joint_loads: Some(joint_loads),
            ..Border::new(DMatrix::identity(velocities, velocities), all.offset)
        };
        Constrained::build(fluid, border, drive, &loads)
    }
}
