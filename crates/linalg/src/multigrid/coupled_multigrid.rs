//! The V-cycle for matrices of 3 x 3 blocks.

use super::coarse::CoarseSolver;
use super::level::{Coupled, Level};
use super::{LevelSize, MultigridParams, apply_cycle};
use crate::bordered::nodes;
use crate::chebyshev::JacobiScaling;
use crate::columns::{assert_lengths, in_passes};
use crate::csr::{check_finite, check_shape, positive_diagonal};
use crate::product::multiply;
use crate::smoothed_aggregation::coupled::{self, NearNullSpace};
use crate::transpose::{symmetric_part, transpose};
use crate::vector::{max_abs, power_of_two_below};
use crate::{
    CoupledOperator, Csr, LinalgError, LinearOperator, Preconditioner, PreconditionerKind,
};

/// One V-cycle of smoothed aggregation as an approximate inverse of a [`CoupledOperator`].
///
/// For symmetric positive definite matrices of vector problems whose components are coupled. The
/// coarse spaces contain the translations, and the rotations too if
/// [`with_rigid_motions`](CoupledMultigrid::with_rigid_motions) is used, which linear elasticity
/// with free surfaces needs. Nodes are aggregated by the Frobenius norms of their blocks, as in
/// [`Coarsening::Standard`](crate::Coarsening::Standard) whatever
/// [`MultigridParams::coarsening`] is; the smoother is that of [`Multigrid`](super::Multigrid) with
/// the row sums `sum_j |k_ij|` of single dofs. A dof whose row has no off-diagonal nonzero, such as
/// a prescribed component, is left to the smoother. The cycle runs in f32, is symmetric to its
/// precision, and the same on any number of threads.
///
/// Quadratic elements need more iterations than linear ones: 104, and 57 with rigid motions, for
/// linear elasticity in a cube with 4 600 nodes, clamped on one side and with a uniform load, to
/// 1e-8; 80 and 49 with 650 nodes; 92 and 49 for a random load on 4 600 nodes.
/// [`Multigrid`](super::Multigrid) of the Laplacian takes 92 and 82 there, which are cheaper.
///
/// Cost of `apply`: two passes over the finest matrix, four over the others, in blocks of 52 bytes.
///
/// ```
/// use linalg::{
///     CoupledMultigrid, CoupledOperator, Csr33, KrylovParams, LinearOperator, MultigridParams, cg,
/// };
/// // a chain of 1000 masses on anisotropic springs, fixed at both ends
/// let n = 1000;
/// let spring = [[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 1.0]];
/// let (mut starts, mut columns, mut blocks) = (vec![0], Vec::new(), Vec::new());
/// for i in 0..n as u32 {
///     for j in i.saturating_sub(1)..=(i + 1).min(n as u32 - 1) {
///         let factor = if i == j { 2.0 } else { -1.0 };
///         columns.push(j);
///         blocks.push(spring.map(|row| row.map(|s: f64| factor * s)));
///     }
///     starts.push(columns.len());
/// }
/// let a = CoupledOperator::new(Csr33::new((n, n), starts, columns, blocks))?;
/// let mut multigrid = CoupledMultigrid::new(&a, &MultigridParams::default())?;
/// let mut u = vec![0.0; a.rows()];
/// let report = cg(&a, &mut multigrid, &vec![1.0; a.rows()], &mut u, &KrylovParams::default())?;
/// assert!(report.iterations < 30);
/// // the forces (1, 1, 1) stretch the springs by (1/3, 1/3, 1) times `(i + 1) (n - i) / 2`
/// assert!((u[3 * 500] / (501.0 * 500.0 / 6.0) - 1.0).abs() < 1e-3);
/// # Ok::<(), linalg::LinalgError>(())
/// ```
pub struct CoupledMultigrid {
    levels: Vec<Level<Coupled>>,
    coarse: CoarseSolver,
    sizes: Vec<LevelSize>,
    /// Power of two by which the operator is divided.
    unit: f64,
}

impl CoupledMultigrid {
    /// Builds all coarse levels, whose spaces contain the translations.
    ///
    /// # Errors
    /// [`LinalgError::NotSymmetric`], [`LinalgError::NotPositive`], [`LinalgError::Parameter`],
    /// [`LinalgError::CoarseningStalled`], [`LinalgError::Factorisation`] for a singular matrix.
    pub fn new(operator: &CoupledOperator, params: &MultigridParams) -> Result<Self, LinalgError> {
        let near_null = NearNullSpace::translations(operator.rows() / 3);
        Self::build(symmetric(operator)?, near_null, params)
    }

    /// Builds the hierarchy for the symmetric part `(A + A^T) / 2` of a nonsymmetric operator, with
    /// coarse spaces that contain the translations.
    ///
    /// A preconditioner of `A` for [`fgmres`](crate::fgmres), as
    /// [`ScalarMultigrid::from_symmetric_part`](crate::ScalarMultigrid::from_symmetric_part): for
    /// viscous terms with convection, as in a step of Picard or Newton.
    ///
    /// # Errors
    /// [`LinalgError::Shape`] for a matrix that is not square, and those of
    /// [`CoupledMultigrid::new`].
    pub fn from_symmetric_part(
        operator: &CoupledOperator,
        params: &MultigridParams,
    ) -> Result<Self, LinalgError> {
        let near_null = NearNullSpace::translations(operator.rows() / 3);
        let part = symmetric_part(&operator.to_interleaved())?;
        Self::build(part, near_null, params)
    }

    /// Builds all coarse levels, whose spaces contain the rigid motions of nodes at `positions`.
    ///
    /// A coarse level has six dofs per aggregate instead of three, and 4 times the nonzeros.
    ///
    /// # Errors
    /// Those of [`CoupledMultigrid::new`], [`LinalgError::Shape`] unless there is one position per
    /// node, [`LinalgError::NotFinite`].
    pub fn with_rigid_motions(
        operator: &CoupledOperator,
        positions: &[[f64; 3]],
        params: &MultigridParams,
    ) -> Result<Self, LinalgError> {
        let nodes = operator.rows() / 3;
        check_shape("positions of nodes", (positions.len(), 3), (nodes, 3))?;
        check_finite("positions of nodes", positions.as_flattened())?;
        let near_null = NearNullSpace::rigid_motions(positions);
        Self::build(symmetric(operator)?, near_null, params)
    }

    fn build(
        mut k: Csr,
        mut near_null: NearNullSpace,
        params: &MultigridParams,
    ) -> Result<Self, LinalgError> {
        params.check()?;
        let diagonal = positive_diagonal("matrix of 3 x 3 blocks", &k)?;
        let unit = power_of_two_below(max_abs(&diagonal));
        let (mut levels, mut sizes) = (Vec::new(), Vec::new());
        while k.rows() / 3 > params.coarsest_nodes {
            positive_diagonal("coarse matrix of 3 x 3 blocks", &k)?;
            let scaling = JacobiScaling::new(&k)?;
            let Some((p, coarse_null)) =
                coupled::prolongation(&k, &scaling, &near_null, params.strength)
            else {
                params.check_stalled(levels.len(), k.rows() / 3)?;
                break;
            };
            let factors = params.relaxation_factors(levels.len(), scaling.upper);
            sizes.push(size(&k, p.nnz(), factors.len()));
            let (level, coarse) = rayon::join(
                || Level::coupled(&k, &p, &scaling.diagonal, unit.recip(), &factors),
                || multiply(&transpose(&p), &multiply(&k, &p)),
            );
            levels.push(level);
            k = coupled::regularised(coarse);
            near_null = coarse_null;
        }
        sizes.push(size(&k, 0, 0));
        Ok(CoupledMultigrid {
            coarse: CoarseSolver::coupled(&k, unit.recip(), params)?,
            levels,
            sizes,
            unit,
        })
    }

    /// Sizes from the finest level down; nonzeros are those of the scalar matrices.
    ///
    /// With rigid motions, an aggregate is two nodes of the next level.
    pub fn level_sizes(&self) -> &[LevelSize] {
        &self.sizes
    }

    fn pass<const S: usize>(&mut self, r: [&[f64]; S], z: [&mut [f64]; S]) {
        assert_lengths(&r, self.size(), &z, self.size());
        let (size, rows) = (r.map(max_abs), r.map(nodes));
        let residual = |i: usize| rows.map(|r| r[i]);
        let (levels, coarse) = (&mut self.levels, &mut self.coarse);
        apply_cycle(levels, coarse, self.unit, size, residual, [&[]; S], z);
    }
}

/// The interleaved matrix of a symmetric operator.
fn symmetric(operator: &CoupledOperator) -> Result<Csr, LinalgError> {
    if !operator.is_symmetric() {
        let method = "multigrid for a matrix of 3 x 3 blocks";
        return Err(LinalgError::NotSymmetric { method });
    }
    Ok(operator.to_interleaved())
}

fn size(k: &Csr, prolongation_nnz: usize, sweeps: usize) -> LevelSize {
    LevelSize {
        nodes: k.rows() / 3,
        nnz: k.nnz(),
        border_nnz: 0,
        prolongation_nnz,
        sweeps,
    }
}

impl Preconditioner for CoupledMultigrid {
    fn size(&self) -> usize {
        3 * self.sizes[0].nodes
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.pass([r], [z]);
    }

    fn apply_columns(&mut self, r: &[&[f64]], z: &mut [&mut [f64]]) {
        in_passes!(self.pass(r, z));
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::PositiveDefinite
    }
}
