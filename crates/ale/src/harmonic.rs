//! Harmonic extension: a scalar diffusion equation.

use fem::DirichletCondition;
use linalg::{Bordered, Multigrid, MultigridParams};
use mesh::Vec3;

use crate::extension::{extend, krylov, scalar_product};
use crate::{AleError, MeshMotion, MovingMesh, Stiffening};

/// Harmonic extension: `∇·(c ∇d) = 0` for each component, with the coefficient of a [`Stiffening`].
///
/// Linear elements on the vertices. Cost: one scalar multigrid set-up per mesh and 10 to 15
/// iterations of CG per field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Harmonic(
    /// The coefficient `c`.
    pub Stiffening,
);

impl MeshMotion for Harmonic {
    fn name(&self) -> &'static str {
        match self.0 {
            Stiffening::None => "laplace",
            Stiffening::KanchiMasud => "kanchi-masud",
            Stiffening::InverseVolume => "inverse-volume",
        }
    }

    fn is_scalar(&self) -> bool {
        true
    }

    fn extend(&self, moving: &MovingMesh<'_>, fields: &mut [Vec<Vec3>]) -> Result<usize, AleError> {
        moving.check(fields)?;
        let condition = DirichletCondition::new(moving.prescribed);
        if condition.n_free() == 0 {
            return Ok(0);
        }
        let coefficients = self.0.coefficients(moving.mesh);
        let stiffness = moving
            .space
            .weighted_vertex_stiffness(moving.mesh, &coefficients)?;
        let operator = Bordered::scalar(condition.restrict_matrix(&stiffness, 1)?)?;
        let mut multigrid = Multigrid::new(&operator, &MultigridParams::default())?;
        let apply = |field: &[Vec3]| scalar_product(&stiffness, field);
        let params = krylov(300);
        let iterations = extend(
            &condition,
            &apply,
            &operator,
            &mut multigrid,
            &params,
            fields,
        )?;
        Ok(iterations)
    }
}
