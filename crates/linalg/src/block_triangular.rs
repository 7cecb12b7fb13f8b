//! The block-triangular preconditioner of a saddle-point system.

use std::array::from_fn;

use crate::bordered::nodes;
use crate::columns::{in_passes, of_buffer, split, split_mut};
use crate::pressure::{PressureInverse, SchurInertia};
use crate::vector::{for_each_chunk, max_abs};
use crate::{
    Csr, LinalgError, LinearOperator, Multigrid, MultigridParams, Preconditioner,
    PreconditionerKind, Prolongation, SaddleSystem,
};

/// Preconditioner `[A B^T; 0 -M_p]^-1` for a saddle-point system.
///
/// A V-cycle `V` approximates the inverse of the velocity and border block `A`, Chebyshev steps
/// that of the pressure mass matrix `M_p`. Use
/// [`with_pressure_laplacian`](BlockTriangular::with_pressure_laplacian) where `M_p` is a poor
/// approximation of the Schur complement.
///
/// One application computes `z_p = -M_p^-1 r_p`, then `z_a = V (r_a - [B^T; E_l^T] z_p)`. It is
/// linear but not symmetric: use [`fgmres`](crate::fgmres). The mass matrix must carry the factor
/// `1 / viscosity`, see [`SaddleSystem`].
///
/// The preconditioner shares the matrices of its system and has no lifetime, so that both can be
/// fields of one struct.
pub struct BlockTriangular {
    system: SaddleSystem,
    velocity: Multigrid,
    pressure: PressureInverse,
    /// Border rows of the right-hand sides of the velocity block, one column after another.
    border: Vec<f64>,
}

impl BlockTriangular {
    /// Uses `velocity`, a multigrid hierarchy built for [`SaddleSystem::velocity_block`].
    ///
    /// # Errors
    /// [`LinalgError::Shape`] if `velocity` was built for another operator, and those of
    /// [`MassInverse::new`](crate::MassInverse::new).
    pub fn new(system: &SaddleSystem, velocity: Multigrid) -> Result<Self, LinalgError> {
        let size = system.velocity_block().rows();
        crate::csr::check_shape("velocity multigrid", (velocity.size(), 1), (size, 1))?;
        Ok(BlockTriangular {
            velocity,
            pressure: PressureInverse::new(system)?,
            border: Vec::new(),
            system: system.clone(),
        })
    }

    /// Builds a multigrid hierarchy with default parameters.
    ///
    /// `prolongation` leads to the first coarse level, smoothed aggregation to the others.
    ///
    /// # Errors
    /// Those of [`Multigrid::with_prolongation`] and [`MassInverse::new`](crate::MassInverse::new).
    pub fn with_prolongation(
        system: &SaddleSystem,
        prolongation: &Prolongation,
    ) -> Result<Self, LinalgError> {
        let a = system.velocity_block();
        let params = MultigridParams::default();
        Self::new(
            system,
            Multigrid::with_prolongation(a, prolongation, None, &params)?,
        )
    }

    /// Adds the inverse of a Laplacian `L` to that of the mass matrix.
    ///
    /// The pressure becomes `z_p = -(M_p^-1 + L^-1) r_p`.
    ///
    /// `L` (np x np) is symmetric and positive semidefinite, with the constants in its null space.
    ///
    /// The sum approximates the inverse of a Schur complement that behaves like a mass matrix for
    /// some pressures and like a Laplacian for others (Cahouet, Chabert, Int. J. Numer. Methods
    /// Fluids 8, 1988). In Stokes flow this happens in narrow gaps: between walls at the distance h
    /// a pressure gradient drives a mean velocity of `h^2 / 12` times its size (at viscosity 1). A
    /// Laplacian with twice this coefficient, `L = ∫ h^2 / 6 ∇psi_p · ∇psi_q`, was measured to
    /// need the fewest iterations. Where no walls are close, h and `L` are large, and `M_p^-1`
    /// dominates the sum.
    ///
    /// Cost per application: one V-cycle for a matrix of the size of the pressure.
    ///
    /// # Errors
    /// [`LinalgError::Shape`], and those of [`Multigrid::new`].
    pub fn with_pressure_laplacian(mut self, laplacian: &Csr) -> Result<Self, LinalgError> {
        self.pressure = self.pressure.with_pressure_laplacian(laplacian)?;
        Ok(self)
    }

    /// Adds the Schur complement of inertia in the velocity block, as of a time step.
    ///
    /// The pressure becomes `z_p = -(M_p^-1 (1 + N_r L^-1) + κ L_b^-1) r_p` (Cahouet, Chabard 1988;
    /// Kay, Loghin, Wathen 2002). `N_r` is `N_p` less half of its boundary term at the inflow.
    /// `L_b / κ` contains the motions of the border with its corner `G`: it is `L / κ + E G^-1
    /// E_l^T`. Bodies are as mobile as their mass allows, also those without mass.
    ///
    /// Cost per application: one V-cycle for a matrix of the size of the pressure, a product with
    /// `N_p`, and `2m` vectors for a border of m columns; memory m vectors.
    ///
    /// # Errors
    /// [`LinalgError::Shape`], [`LinalgError::Factorisation`] for a border that is singular, and
    /// those of [`Multigrid::new`].
    pub fn with_inertia(mut self, inertia: &SchurInertia) -> Result<Self, LinalgError> {
        self.pressure = self.pressure.with_inertia(&self.system, inertia)?;
        Ok(self)
    }

    fn pass<const S: usize>(&mut self, r: [&[f64]; S], z: [&mut [f64]; S]) {
        let system = &self.system;
        let (ra, rp) = split(r, self.velocity.size());
        let (za, mut zp) = split_mut(z, self.velocity.size());
        self.pressure.pass(rp, zp.each_mut().map(|z| &mut **z));
        for zp in &mut zp {
            for_each_chunk(zp, &|_, zp| zp.iter_mut().for_each(|p| *p = -*p));
        }
        let zp = zp.each_ref().map(|z| &**z);
        let (ru, rv) = split(ra, system.velocity_range().end);
        let m = system.border_range().len();
        self.border.clear();
        for rv in rv {
            self.border.extend_from_slice(rv);
        }
        system.subtract_border_gradient(zp, of_buffer(&mut self.border, m));
        let border = of_buffer(&mut self.border, m).map(|b| &*b);
        // the residual is about as large as `r_a`; the pressure gradient cancels a part of it
        let size = from_fn(|s| max_abs(ra[s]).max(max_abs(border[s])));
        let (gradient, ru) = (system.gradient_rows(zp), ru.map(nodes));
        let residual = |i: usize| {
            let g = gradient(i);
            from_fn(|s| from_fn(|d| ru[s][i][d] - g[s][d]))
        };
        self.velocity.apply_to(size, residual, border, za);
    }

    /// The multigrid hierarchy of the velocity block, for its table of levels.
    pub fn velocity(&self) -> &Multigrid {
        &self.velocity
    }

    /// The multigrid hierarchy of the velocity block, to run its parts.
    pub fn velocity_mut(&mut self) -> &mut Multigrid {
        &mut self.velocity
    }
}

impl Preconditioner for BlockTriangular {
    fn size(&self) -> usize {
        self.system.rows()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.pass([r], [z]);
    }

    fn apply_columns(&mut self, r: &[&[f64]], z: &mut [&mut [f64]]) {
        in_passes!(self.pass(r, z));
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::Linear
    }
}
