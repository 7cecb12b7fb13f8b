//! The block-diagonal preconditioner of a symmetric saddle-point system.

use crate::pressure::PressureInverse;
use crate::{
    BorderInverse, Csr, LinalgError, LinearOperator, Multigrid, MultigridParams, Preconditioner,
    PreconditionerKind, Prolongation, SaddleSystem,
};

/// Preconditioner `[A 0; 0 S]^-1` for a symmetric saddle-point system.
///
/// A V-cycle approximates the inverse of the velocity and border block `A`. That of the Schur
/// complement `S` is the one of [`BlockTriangular`](crate::BlockTriangular), based on the pressure
/// mass matrix.
///
/// Symmetric positive definite, as [`minres`](crate::minres) requires. If the border contains
/// Lagrange multipliers, the cycle must use the absolute value of the border's Schur complement,
/// [`BorderInverse::Absolute`]. The mass matrix must carry the factor `1 / viscosity`, see
/// [`SaddleSystem`]. With this preconditioner MINRES takes about twice the iterations of
/// [`fgmres`](crate::fgmres) with [`BlockTriangular`](crate::BlockTriangular), and a fifth of the
/// memory for vectors.
pub struct BlockDiagonal {
    velocity: Multigrid,
    size: usize,
    pressure: PressureInverse,
}

impl BlockDiagonal {
    /// Uses `velocity`, a multigrid hierarchy built for [`SaddleSystem::velocity_block`].
    ///
    /// # Errors
    /// [`LinalgError::NotSymmetric`], [`LinalgError::UnsuitablePreconditioner`] if `velocity` is
    /// not positive definite, [`LinalgError::Shape`] if it was built for another operator, and
    /// those of [`MassInverse::new`](crate::MassInverse::new).
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
        Ok(BlockDiagonal {
            velocity,
            size: system.rows(),
            pressure: PressureInverse::new(system)?,
        })
    }

    /// Adds the inverse of a Laplacian to that of the mass matrix.
    ///
    /// As [`BlockTriangular::with_pressure_laplacian`](crate::BlockTriangular).
    ///
    /// # Errors
    /// [`LinalgError::Shape`] for a matrix of another size than the mass matrix, and those of
    /// [`Multigrid::new`].
    pub fn with_pressure_laplacian(mut self, laplacian: &Csr) -> Result<Self, LinalgError> {
        self.pressure = self.pressure.with_pressure_laplacian(laplacian)?;
        Ok(self)
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
        self.size
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        let split = self.velocity.size();
        self.velocity.apply(&r[..split], &mut z[..split]);
        self.pressure.pass([&r[split..]], [&mut z[split..]]);
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::PositiveDefinite
    }
}
