//! The block-diagonal preconditioner of a symmetric saddle-point system.

use crate::pressure::MASS_STEPS;
use crate::{
    BorderInverse, LinalgError, LinearOperator, MassInverse, Multigrid, MultigridParams,
    Preconditioner, PreconditionerKind, Prolongation, SaddleSystem,
};

/// `[A 0; 0 M_p]^-1`, with a V-cycle for the velocity and border block `A` and Chebyshev steps for the pressure mass matrix.
///
/// Symmetric positive definite: for [`minres`](crate::minres). Where the border holds multipliers the cycle must invert its absolute
/// value, [`BorderInverse::Absolute`]. The mass matrix must carry `1 / viscosity`, see [`SaddleSystem`].
/// It needs about twice the iterations of [`BlockTriangular`](crate::BlockTriangular) with
/// [`fgmres`](crate::fgmres), and a fifth of the memory for vectors.
pub struct BlockDiagonal {
    velocity: Multigrid,
    mass: MassInverse,
}

impl BlockDiagonal {
    /// With a multigrid made for [`SaddleSystem::velocity_block`].
    ///
    /// # Errors
    /// [`LinalgError::NotSymmetric`], [`LinalgError::UnsuitablePreconditioner`] when `velocity` is not positive definite, [`LinalgError::Shape`] when it
    /// was made for another operator, and those of [`MassInverse::new`].
    pub fn new(system: &SaddleSystem, velocity: Multigrid) -> Result<Self, LinalgError> {
        let method = "the block-diagonal preconditioner";
        let size = system.velocity_block().rows();
        crate::csr::check_shape("velocity multigrid", (velocity.size(), 1), (size, 1))?;
        if !system.is_symmetric() {
            return Err(LinalgError::NotSymmetric { method });
        }
        if velocity.kind() != PreconditionerKind::PositiveDefinite {
            return Err(LinalgError::UnsuitablePreconditioner {
                method,
                needed: PreconditionerKind::PositiveDefinite,
                found: velocity.kind(),
            });
        }
        let mass = MassInverse::new(system.pressure_mass(), MASS_STEPS)?;
        Ok(BlockDiagonal { velocity, mass })
    }

    /// With the multigrid P2 -> P1 -> smoothed aggregation of default parameters and [`BorderInverse::Absolute`].
    ///
    /// # Errors
    /// Those of [`BlockDiagonal::new`] and [`Multigrid::with_prolongation`].
    pub fn with_prolongation(
        system: &SaddleSystem,
        prolongation: &Prolongation,
    ) -> Result<Self, LinalgError> {
        let params = MultigridParams {
            border: BorderInverse::Absolute,
            ..MultigridParams::default()
        };
        let a = system.velocity_block();
        Self::new(
            system,
            Multigrid::with_prolongation(a, prolongation, None, &params)?,
        )
    }
}

impl Preconditioner for BlockDiagonal {
    fn size(&self) -> usize {
        self.velocity.size() + self.mass.size()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        let split = self.velocity.size();
        self.velocity.apply(&r[..split], &mut z[..split]);
        self.mass.apply(&r[split..], &mut z[split..]);
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::PositiveDefinite
    }
}
