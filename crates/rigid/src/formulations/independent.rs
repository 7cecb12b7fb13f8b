//! The formulation P: bodies without joints, every velocity a dof.

use nalgebra::{DMatrix, DVector};

use super::Formulation;
use crate::constrained::Border;
use crate::{Constrained, Constraints, Drive, Reduction, RigidError, RigidFluid};

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
        if let Some(body) = drive.set.fixed().iter().position(|&fixed| fixed) {
            return Err(RigidError::FixedWithoutConstraint { body });
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
