//! The block-triangular preconditioner of a saddle-point system.

use crate::{
    LinalgError, LinearOperator, MassInverse, Multigrid, MultigridParams, Preconditioner,
    PreconditionerKind, SaddleSystem, Transfer,
};

/// Chebyshev steps on the pressure mass matrix: two or three need the same iterations, one needs three more (methods note 1.2).
pub(crate) const MASS_STEPS: usize = 3;

/// `[A B^T; 0 -M_p]^-1`, with a V-cycle for the velocity and border block `A` and Chebyshev steps for the pressure mass matrix.
///
/// `z_p = -M_p^-1 r_p`, then `z_a = V (r_a - [B^T; E_l^T] z_p)`. Linear, not symmetric: use [`fgmres`](crate::fgmres).
/// The mass matrix must carry `1 / viscosity`, see [`SaddleSystem`].
pub struct BlockTriangular<'a> {
    system: &'a SaddleSystem,
    velocity: Multigrid,
    mass: MassInverse,
    work: Vec<f64>,
}

impl<'a> BlockTriangular<'a> {
    /// With a multigrid made for [`SaddleSystem::velocity_block`].
    ///
    /// # Errors
    /// [`LinalgError::Shape`] when `velocity` was made for another operator, and those of [`MassInverse::new`].
    pub fn new(system: &'a SaddleSystem, velocity: Multigrid) -> Result<Self, LinalgError> {
        let size = system.velocity_block().rows();
        crate::csr::check_shape("velocity multigrid", (velocity.size(), 1), (size, 1))?;
        Ok(BlockTriangular {
            velocity,
            mass: MassInverse::new(system.pressure_mass(), MASS_STEPS)?,
            work: vec![0.0; size],
            system,
        })
    }

    /// With the multigrid P2 -> P1 -> smoothed aggregation of default parameters.
    ///
    /// # Errors
    /// Those of [`Multigrid::with_transfer`] and [`MassInverse::new`].
    pub fn with_transfer(
        system: &'a SaddleSystem,
        transfer: &Transfer,
    ) -> Result<Self, LinalgError> {
        let a = system.velocity_block();
        let params = MultigridParams::default();
        Self::new(
            system,
            Multigrid::with_transfer(a, transfer, None, &params)?,
        )
    }

    /// The velocity multigrid, for its table of levels.
    pub fn velocity(&self) -> &Multigrid {
        &self.velocity
    }
}

impl Preconditioner for BlockTriangular<'_> {
    fn size(&self) -> usize {
        self.system.rows()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        let (ra, rp) = r.split_at(self.work.len());
        let (za, zp) = z.split_at_mut(self.work.len());
        self.mass.apply(rp, zp);
        zp.iter_mut().for_each(|p| *p = -*p);
        self.work.copy_from_slice(ra);
        self.system.subtract_gradient(zp, &mut self.work);
        self.velocity.apply(&self.work, za);
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::Linear
    }
}
