//! The direct-row formulation: constraints replace force rows of linked bodies.

use nalgebra::DMatrix;

use super::Formulation;
use crate::constrained::Border;
use crate::{Constrained, Drive, RigidError, RigidFluid};

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
