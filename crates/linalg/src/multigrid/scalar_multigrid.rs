//! The V-cycle for vectors with one component.

use super::{Multigrid, MultigridParams};
use crate::vector::max_abs;
use crate::{Bordered, CsrOperator, LevelSize, LinalgError, Preconditioner, PreconditionerKind};

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
        let method = "multigrid for a scalar matrix";
        if !crate::LinearOperator::is_symmetric(operator) {
            return Err(LinalgError::NotSymmetric { method });
        }
        Self::from_scalar(&Bordered::shared(operator.shared_matrix())?, params)
    }

    /// Builds the hierarchy for the scalar matrix of `operator`, which has no border.
    pub(crate) fn from_scalar(
        operator: &Bordered,
        params: &MultigridParams,
    ) -> Result<Self, LinalgError> {
        let cycle = Multigrid::new(operator, params)?;
        Ok(ScalarMultigrid {
            solution: vec![0.0; cycle.size()],
            cycle,
        })
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
