//! The V-cycle for vectors with one component.

use super::{LevelSize, Multigrid, MultigridParams};
use crate::transpose::symmetric_part;
use crate::vector::max_abs;
use crate::{
    Bordered, Csr, CsrOperator, LinalgError, LinearOperator, Preconditioner, PreconditionerKind,
    Prolongation,
};

/// One V-cycle of smoothed aggregation as an approximate inverse of a [`CsrOperator`].
///
/// For scalar problems with a symmetric positive definite matrix. A singular matrix, as of a
/// Poisson problem with Neumann conditions on the whole boundary, needs
/// [`MultigridParams::with_coarsest_shift`], and its null space
/// ([`KrylovParams::with_null_vectors`](crate::KrylovParams::with_null_vectors)) in the Krylov
/// method.
///
/// This is the cycle of [`Multigrid`] with two of the three components zero. A cycle reads the
/// matrices once, as for three components, and its vectors are four times as long as necessary.
/// Three right-hand sides with one matrix are better solved together, by [`Bordered::scalar`] and
/// [`Multigrid`].
///
/// Coefficients that vary strongly need [`MultigridParams::heterogeneous`], anisotropy
/// [`MultigridParams::anisotropic`].
///
/// ```
/// use linalg::{CsrOperator, KrylovParams, MultigridParams, ScalarMultigrid, cg};
/// // -u'' = 1, u = 0 at both ends
/// let n = 2000;
/// let mut a = sprs::TriMatI::<f64, u32>::new((n, n));
/// for i in 0..n {
///     a.add_triplet(i, i, 2.0);
///     if i > 0 {
///         a.add_triplet(i, i - 1, -1.0);
///         a.add_triplet(i - 1, i, -1.0);
///     }
/// }
/// let a = CsrOperator::new(a.to_csr())?;
/// let mut multigrid = ScalarMultigrid::new(&a, &MultigridParams::default())?;
/// let mut u = vec![0.0; n];
/// let report = cg(&a, &mut multigrid, &vec![1.0; n], &mut u, &KrylovParams::default())?;
/// assert!(report.iterations < 30);
/// // the middle one of `u_i = (i + 1) (n - i) / 2`
/// assert!((u[n / 2] / 500_500.0 - 1.0).abs() < 1e-3);
/// # Ok::<(), linalg::LinalgError>(())
/// ```
pub struct ScalarMultigrid {
    cycle: Multigrid,
    /// The solution in three components.
    solution: Vec<f64>,
}

impl ScalarMultigrid {
    /// Builds the hierarchy of levels for `operator`.
    ///
    /// # Errors
    /// [`LinalgError::Shape`] for a matrix that is not square, [`LinalgError::NotSymmetric`], and
    /// those of [`Multigrid::new`].
    pub fn new(operator: &CsrOperator, params: &MultigridParams) -> Result<Self, LinalgError> {
        Self::from_scalar(&symmetric(operator)?, params)
    }

    /// Builds the first coarse level by a given prolongation, the others by smoothed aggregation.
    ///
    /// The prolongation, [`Prolongation::scalar`], is usually that from P1 to P2 elements.
    /// `coarse_matrix` is the matrix of the coarse space if it is known; otherwise the product
    /// `P^T A P` is computed.
    ///
    /// ```
    /// use linalg::sprs::TriMatI;
    /// use linalg::{CsrOperator, KrylovParams, MultigridParams, Prolongation, ScalarMultigrid, cg};
    /// // -u'' = 1 at 1999 points; every second point is a coarse one, the others interpolate
    /// let n = 1999;
    /// let mut a = TriMatI::<f64, u32>::new((n, n));
    /// let mut p = TriMatI::<f64, u32>::new((n, n / 2));
    /// for i in 0..n {
    ///     a.add_triplet(i, i, 2.0);
    ///     if i > 0 {
    ///         a.add_triplet(i, i - 1, -1.0);
    ///         a.add_triplet(i - 1, i, -1.0);
    ///     }
    /// }
    /// for c in 0..n / 2 {
    ///     for (i, weight) in [(2 * c, 0.5), (2 * c + 1, 1.0), (2 * c + 2, 0.5)] {
    ///         p.add_triplet(i, c, weight);
    ///     }
    /// }
    /// let (a, p) = (CsrOperator::new(a.to_csr())?, Prolongation::scalar(p.to_csr())?);
    /// let params = MultigridParams::default();
    /// let mut multigrid = ScalarMultigrid::with_prolongation(&a, &p, None, &params)?;
    /// assert_eq!(multigrid.level_sizes()[1].nodes, 999);
    /// let mut u = vec![0.0; n];
    /// cg(&a, &mut multigrid, &vec![1.0; n], &mut u, &KrylovParams::default())?;
    /// // the middle one of `u_i = (i + 1) (n - i) / 2`
    /// assert!((u[n / 2] / 500_000.0 - 1.0).abs() < 1e-3);
    /// # Ok::<(), linalg::LinalgError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`ScalarMultigrid::new`] and [`Multigrid::with_prolongation`].
    pub fn with_prolongation(
        operator: &CsrOperator,
        prolongation: &Prolongation,
        coarse_matrix: Option<Csr>,
        params: &MultigridParams,
    ) -> Result<Self, LinalgError> {
        let a = symmetric(operator)?;
        Multigrid::with_prolongation(&a, prolongation, coarse_matrix, params).map(Self::from_cycle)
    }

    /// Builds the hierarchy for the symmetric part `(A + A^T) / 2` of a nonsymmetric operator.
    ///
    /// A preconditioner of `A` for [`fgmres`](crate::fgmres). It suits operators whose symmetric
    /// part dominates, as convection-diffusion with a cell Peclet number up to about one: the
    /// number of iterations is bounded on refined meshes and grows with the ratio of the
    /// skew-symmetric to the symmetric part (Elman, Silvester, Wathen, Finite Elements and Fast
    /// Iterative Solvers, 2014, section 7.1). Equal to [`ScalarMultigrid::new`] to rounding if `A`
    /// is symmetric.
    ///
    /// # Errors
    /// [`LinalgError::Shape`] for a matrix that is not square, and those of [`Multigrid::new`].
    pub fn from_symmetric_part(
        operator: &CsrOperator,
        params: &MultigridParams,
    ) -> Result<Self, LinalgError> {
        let part = symmetric_part(operator.matrix())?;
        Self::from_scalar(&Bordered::scalar(part)?, params)
    }

    /// Builds the hierarchy for the scalar matrix of `operator`, which has no border.
    pub(crate) fn from_scalar(
        operator: &Bordered,
        params: &MultigridParams,
    ) -> Result<Self, LinalgError> {
        Multigrid::new(operator, params).map(Self::from_cycle)
    }

    fn from_cycle(cycle: Multigrid) -> Self {
        ScalarMultigrid {
            solution: vec![0.0; cycle.size()],
            cycle,
        }
    }

    /// Sizes from the finest level down.
    pub fn level_sizes(&self) -> &[LevelSize] {
        self.cycle.level_sizes()
    }

    /// Calls `take(z_i, v_i)` for each entry, with `v` the approximate solution for `r`.
    pub(crate) fn solve_into(&mut self, r: &[f64], z: &mut [f64], take: impl Fn(&mut f64, f64)) {
        assert_eq!((r.len(), z.len()), (self.size(), self.size()), "lengths");
        let rows = |i: usize| [[r[i], 0.0, 0.0]];
        let solution = &mut self.solution;
        self.cycle.apply_to([max_abs(r)], rows, [&[]], [solution]);
        for (z, [v, ..]) in z.iter_mut().zip(self.solution.as_chunks::<3>().0) {
            take(z, *v);
        }
    }
}

/// The matrix of a symmetric operator for one component of three.
fn symmetric(operator: &CsrOperator) -> Result<Bordered, LinalgError> {
    let method = "multigrid for a scalar matrix";
    if !operator.is_symmetric() {
        return Err(LinalgError::NotSymmetric { method });
    }
    Bordered::shared(operator.shared_matrix())
}

impl Preconditioner for ScalarMultigrid {
    fn size(&self) -> usize {
        self.solution.len() / 3
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.solve_into(r, z, |z, v| *z = v);
    }

    fn kind(&self) -> PreconditionerKind {
        self.cycle.kind()
    }
}
