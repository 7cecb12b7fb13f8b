//! Extension as the displacement of an elastic solid whose small elements are stiff.

use fem::DirichletCondition;
use linalg::{Bordered, Csr, LinearOperator, Multigrid, MultigridParams};
use mesh::Vec3;

use crate::extension::{extend, krylov, product};
use crate::{AleError, MeshMotion, MovingMesh, Stiffening};

/// $\int c\,(2 D(d):D(v) + \lambda\, \nabla\cdot d\; \nabla\cdot v) = 0$, $\lambda = 2\nu/(1-2\nu)$, $c = V_{max}/V_e$: linear
/// elasticity with Jacobian-based stiffening of exponent one (Stein, Tezduyar & Benney, J. Appl. Mech. 70, 2003).
///
/// Components couple, so a body needs three vector fields where scalar methods need one scalar field. Cost: CG on a matrix
/// with nine times the entries, preconditioned by the multigrid cycle of the scalar operator with the same coefficient, which
/// Korn's inequality makes an equivalent one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Elastic {
    /// Poisson's ratio, from 0 to below 1/2: how much a volume resists being changed.
    pub poisson: f64,
}

/// The free block of the elastic matrix.
struct FreeBlock(Csr);

impl LinearOperator for FreeBlock {
    fn rows(&self) -> usize {
        self.0.rows()
    }

    fn cols(&self) -> usize {
        self.0.cols()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        product(&self.0, x, y);
    }

    fn is_symmetric(&self) -> bool {
        true
    }
}

impl MeshMotion for Elastic {
    fn name(&self) -> &'static str {
        "elastic"
    }

    fn is_scalar(&self) -> bool {
        false
    }

    fn extend(&self, moving: &MovingMesh<'_>, fields: &mut [Vec<Vec3>]) -> Result<(), AleError> {
        if !(0.0..0.5).contains(&self.poisson) {
            return Err(AleError::Parameter {
                name: "Poisson's ratio",
                value: self.poisson,
                range: "from 0 to below 1/2",
            });
        }
        let condition = DirichletCondition::new(moving.prescribed);
        if condition.n_free() == 0 {
            return Ok(());
        }
        let coefficients = Stiffening::InverseVolume.coefficients(moving.mesh);
        let lame = 2.0 * self.poisson / (1.0 - 2.0 * self.poisson);
        let elastic = moving
            .space
            .vertex_elasticity(moving.mesh, &coefficients, lame)?;
        let scalar = moving
            .space
            .weighted_vertex_stiffness(moving.mesh, &coefficients)?;
        let scalar = Bordered::scalar(condition.restrict_matrix(&scalar, 1))?;
        let mut multigrid = Multigrid::new(&scalar, &MultigridParams::default())?;
        let apply = |field: &[Vec3]| {
            let flat: Vec<f64> = field.iter().flat_map(|&d| <[f64; 3]>::from(d)).collect();
            let mut image = vec![0.0; flat.len()];
            product(&elastic, &flat, &mut image);
            image
                .as_chunks::<3>()
                .0
                .iter()
                .map(|&d| Vec3::from(d))
                .collect()
        };
        let operator = FreeBlock(condition.restrict_matrix(&elastic, 3));
        let params = krylov(1000);
        extend(
            &condition,
            &apply,
            &operator,
            &mut multigrid,
            &params,
            fields,
        )?;
        Ok(())
    }
}
