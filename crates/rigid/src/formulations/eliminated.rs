//! The formulation P-tilde: velocities of linked bodies are eliminated.

use super::Formulation;
use crate::constrained::Border;
use crate::{Constrained, Drive, RigidError, RigidFluid};

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
