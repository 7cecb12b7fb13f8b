//! The block-diagonal preconditioner of a symmetric saddle-point system.

use crate::pressure::MASS_STEPS;
use crate::{
    BorderInverse, LinalgError, LinearOperator, MassInverse, Multigrid, MultigridParams,
    Preconditioner, PreconditionerKind, Prolongation, SaddleSystem,
};

/// Preconditioner `[A 0; 0 M_p]^-1` for a symmetric saddle-point system.
///
/// A V-cycle approximates the inverse of the velocity and border block `A`, Chebyshev steps that of
/// the pressure mass matrix `M_p`.
///
/// Symmetric positive definite, as [`minres`](crate::minres) requires. If the border contains
/// Lagrange multipliers, the cycle must use the absolute value of the border's Schur complement,
/// [`BorderInverse::Absolute`]. The mass matrix must carry the factor `1 / viscosity`, see
/// [`SaddleSystem`]. With this preconditioner MINRES takes about twice the iterations of
/// [`fgmres`](crate::fgmres) with [`BlockTriangular`](crate::BlockTriangular), and a fifth of the
/// memory for vectors.
pub struct BlockDiagonal {
    velocity: Multigrid,
    mass: MassInverse,
}

impl BlockDiagonal {
    /// Uses `velocity`, a multigrid hierarchy built for [`SaddleSystem::velocity_block`].
    ///
    /// # Errors
    /// [`LinalgError::NotSymmetric`], [`LinalgError::UnsuitablePreconditioner`] if `velocity` is
    /// not positive definite, [`LinalgError::Shape`] if it was built for another operator, and
    /// those of [`MassInverse::new`].
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

    /// Builds a multigrid hierarchy with default parameters and [`BorderInverse::Absolute`].
    ///
    /// `prolongation` leads to the first coarse level, smoothed aggregation to the others.
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
