//! Extension as the displacement of a linear elastic solid with stiff small elements.

use fem::DirichletCondition;
use linalg::{Bordered, Csr, LinearOperator, Multigrid, MultigridParams};
use mesh::Vec3;

use crate::extension::{extend, krylov, product};
use crate::{AleError, MeshMotion, MovingMesh, Stiffening};

/// Linear elasticity with Jacobian-based stiffening of exponent one (Stein, Tezduyar & Benney,
/// J. Appl. Mech. 70, 2003).
///
/// ```text
/// ∫ c (2 D(d):D(v) + λ ∇·d ∇·v) = 0,   λ = 2ν / (1 - 2ν),   c = V_max / V_e
/// ```
///
/// The components are coupled, so each body needs three vector fields where scalar methods need one
/// scalar field. Cost: CG on a matrix with nine times as many nonzeros, preconditioned by the
/// multigrid cycle of the scalar operator with the same coefficient, which is spectrally equivalent
/// by Korn's inequality.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Elastic {
    /// Poisson's ratio `ν`, at least 0, the default, and below 1/2; larger values preserve cell
    /// volumes better.
    pub poisson: f64,
}

impl Elastic {
    /// The method with Poisson's ratio `poisson`, which [`MeshMotion`] checks.
    pub fn new(poisson: f64) -> Self {
        Self { poisson }
    }
}

/// The elasticity matrix on the free vertices.
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

    fn extend(&self, moving: &MovingMesh<'_>, fields: &mut [Vec<Vec3>]) -> Result<usize, AleError> {
        if !(0.0..0.5).contains(&self.poisson) {
            return Err(AleError::Parameter {
                name: "Poisson's ratio",
                value: self.poisson,
                range: "at least 0 and below 1/2",
            });
        }
        moving.check(fields)?;
        let condition = DirichletCondition::new(moving.prescribed);
        if condition.n_free() == 0 {
            return Ok(0);
        }
        let coefficients = Stiffening::InverseVolume.coefficients(moving.mesh);
        let lame = 2.0 * self.poisson / (1.0 - 2.0 * self.poisson);
        let elastic = moving
            .space
            .vertex_elasticity(moving.mesh, &coefficients, lame)?;
        let scalar = moving
            .space
            .weighted_vertex_stiffness(moving.mesh, &coefficients)?;
        let scalar = Bordered::scalar(condition.restrict_matrix(&scalar, 1)?)?;
        let mut multigrid = Multigrid::new(&scalar, &MultigridParams::default())?;
        let apply = |field: &[Vec3]| {
            let interleaved: Vec<f64> = field.iter().flat_map(|&d| <[f64; 3]>::from(d)).collect();
            let mut image = vec![0.0; interleaved.len()];
            product(&elastic, &interleaved, &mut image);
            image
                .as_chunks::<3>()
                .0
                .iter()
                .map(|&d| Vec3::from(d))
                .collect()
        };
        let operator = FreeBlock(condition.restrict_matrix(&elastic, 3)?);
        let params = krylov(1000);
        extend(
            &condition,
            &apply,
            &operator,
            &mut multigrid,
            &params,
            fields,
        )
    }
}
