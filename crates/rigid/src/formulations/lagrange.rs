//! The Lagrange formulation: every velocity a dof, joints imposed by multipliers.

use nalgebra::DMatrix;

use super::Formulation;
use crate::constrained::Border;
use crate::{Constrained, Drive, RigidError, RigidFluid};

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
