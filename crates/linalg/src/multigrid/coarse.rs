//! The exact solver on the coarsest level.

use std::borrow::Cow;
use std::iter;

use nalgebra::{DMatrix, DMatrixViewMut, DVector, Dyn, LU};

use super::level::Vectors;
use super::{BorderInverse, MultigridParams};
use crate::constrained_dofs::ConstrainedDofs;
use crate::csr::{Rows, empty};
use crate::node_kernel::long_row;
use crate::product::build_rows;
use crate::schur::SchurFactor;
use crate::{Bordered, Csr, LinalgError, LinearOperator};

#[cfg(feature = "direct")]
use sparse::CoarseFactor;

#[cfg(not(feature = "direct"))]
use dense::CoarseFactor;

/// Name of the factorised matrix in errors.
const WHAT: &str = "coarsest stiffness matrix";

/// Solves with `[K (x) I3, C; C_l^T, M]`: factors of `K`, and a Schur complement of the border.
///
/// The Schur complement is dense and factorised with pivoting.
///
/// If components are constrained, each component has its own factor of `K`, without its constrained
/// dofs.
///
/// ```text
/// W = (K (x) I3)^-1 C       S = M - C_l^T W
/// t = (K (x) I3)^-1 b_u     v = S^-1 (b_v - C_l^T t)     u = t - W v
/// ```
///
/// Only `K` must be definite: pivoting admits borders with constraints and nonsymmetric ones.
pub(super) struct CoarseSolver {
    /// One factor for all components, or one for each.
    factors: Vec<Factor>,
    border_rows: Csr,
    /// `W`, column by column, each interleaved by node.
    lifted: Vec<f64>,
    schur: SchurFactor,
    /// Whether the map computed by `solve` is symmetric positive definite.
    pub definite: bool,
    pub vectors: Vectors,
    components: Vec<f64>,
    interleaved: Vec<f64>,
    border: DVector<f64>,
}

impl CoarseSolver {
    /// Factorises `unit` times `operator`.
    pub fn new(
        operator: &Bordered,
        unit: f64,
        params: &MultigridParams,
    ) -> Result<Self, LinalgError> {
        let (n, m) = (operator.nodes(), operator.border_len());
        let k = operator.stiffness().map(|v| v * unit);
        let k = shift_diagonal(k, params.coarsest_shift);
        let constrained = operator.constrained_dofs();
        let pinned = (0..3).map(|d| Cow::Owned(constrained.pinned(&k, d)));
        let once = iter::once(Cow::Borrowed(&k));
        let mut factors = match (operator.has_symmetric_stiffness(), constrained.is_empty()) {
            (true, true) => definite(CoarseFactor::all(&k, once, 3)?),
            (true, false) => definite(CoarseFactor::all(&k, pinned, 1)?),
            (false, true) => vec![Factor::general(&k)?],
            (false, false) => pinned
                .map(|k| Factor::general(&k))
                .collect::<Result<_, _>>()?,
        };
        let border_rows = operator.border_rows().map(|v| v * unit);
        let mut lifted = vec![0.0; 3 * n * m];
        let border = Rows::new(operator.border());
        for i in 0..3 * n {
            for (c, v) in border.row(i) {
                lifted[3 * n * c + i] = v * unit;
            }
        }
        let mut components = vec![0.0; 3 * n];
        for column in lifted.chunks_exact_mut((3 * n).max(1)) {
            separate(column, &mut components);
            solve_components(&mut factors, &mut components);
            interleave(&components, column);
        }
        let mut schur = operator.corner() * unit;
        for d in 0..m {
            let column = &lifted[3 * n * d..3 * n * (d + 1)];
            for c in 0..m {
                let [product] = long_row(Rows::new(&border_rows), c, |j| [column[j]]);
                schur[(c, d)] -= product;
            }
        }
        let symmetric = operator.is_symmetric();
        let absolute = symmetric && params.border == BorderInverse::Absolute;
        let definite = absolute || symmetric && schur.clone().cholesky().is_some();
        let schur = if absolute {
            SchurFactor::absolute(schur)?
        } else {
            SchurFactor::new(schur)?
        };
        Ok(CoarseSolver {
            factors,
            border_rows,
            lifted,
            schur,
            definite,
            vectors: Vectors::new(n, m, constrained.clone()),
            components,
            interleaved: vec![0.0; 3 * n],
            border: DVector::zeros(m),
        })
    }

    /// Factorises `unit` times a matrix with three interleaved dofs per node, without a border.
    pub fn coupled(k: &Csr, unit: f64, params: &MultigridParams) -> Result<Self, LinalgError> {
        let n = k.rows() / 3;
        let rows = Rows::new(k);
        // one component after another, as the solve for a border has them
        let separated = build_rows(3 * n, 3 * n, |row, entries| {
            for (j, value) in rows.row(3 * (row % n) + row / n) {
                entries.add(j % 3 * n + j / 3, value * unit);
            }
        });
        let k = shift_diagonal(separated, params.coarsest_shift);
        Ok(CoarseSolver {
            factors: definite(CoarseFactor::all(&k, iter::once(Cow::Borrowed(&k)), 1)?),
            border_rows: empty(0, 3 * n),
            lifted: Vec::new(),
            schur: SchurFactor::new(DMatrix::zeros(0, 0))?,
            definite: true,
            vectors: Vectors::new(n, 0, ConstrainedDofs::default()),
            components: vec![0.0; 3 * n],
            interleaved: vec![0.0; 3 * n],
            border: DVector::zeros(0),
        })
    }

    /// Solves for the right-hand sides in `vectors`.
    ///
    /// One by one: the factor is small and stays in the cache.
    pub fn solve<const S: usize>(&mut self) {
        for s in 0..S {
            self.solve_column::<S>(s);
        }
    }

    fn solve_column<const S: usize>(&mut self, s: usize) {
        let size = self.interleaved.len();
        let vectors = self.vectors.columns::<S>();
        let interleaved = self.interleaved.as_chunks_mut::<3>().0;
        for (t, b) in interleaved.iter_mut().zip(vectors.b) {
            let b = b[s];
            *t = [b[0], b[1], b[2]].map(f64::from);
        }
        separate(&self.interleaved, &mut self.components);
        solve_components(&mut self.factors, &mut self.components);
        interleave(&self.components, &mut self.interleaved);
        for (c, v) in self.border.iter_mut().enumerate() {
            let [known] = long_row(Rows::new(&self.border_rows), c, |j| [self.interleaved[j]]);
            *v = f64::from(vectors.border_b[c][s]) - known;
        }
        self.schur.solve(&mut self.border);
        for (c, v) in self.border.iter().enumerate() {
            vectors.border_x[c][s] = *v as f32;
            let column = &self.lifted[size * c..size * (c + 1)];
            for (t, w) in self.interleaved.iter_mut().zip(column) {
                *t -= w * v;
            }
        }
        for (x, t) in vectors
            .x
            .iter_mut()
            .zip(self.interleaved.as_chunks::<3>().0)
        {
            x[s] = [t[0] as f32, t[1] as f32, t[2] as f32, 0.0];
        }
    }
}

/// Factors of the coarsest scalar matrix.
enum Factor {
    /// Of a symmetric positive definite one.
    Definite(Box<CoarseFactor>),
    /// Dense factors with pivoting, of one with convection, and its rows.
    General(LU<f64, Dyn, Dyn>, usize),
}

impl Factor {
    /// Factorises a matrix that is not symmetric.
    fn general(k: &Csr) -> Result<Self, LinalgError> {
        let n = k.rows();
        let failed = |detail: String| LinalgError::Factorisation { what: WHAT, detail };
        if n > MAX_GENERAL_ROWS {
            return Err(failed(format!(
                "it is not symmetric and has {n} rows, more than {MAX_GENERAL_ROWS}"
            )));
        }
        let mut dense = DMatrix::zeros(n, n);
        for (value, (i, j)) in k.iter() {
            dense[(i as usize, j as usize)] = *value;
        }
        let factors = dense.lu();
        match factors.is_invertible() {
            true => Ok(Self::General(factors, n)),
            false => Err(failed("it is singular".into())),
        }
    }

    /// Overwrites columns, one after another, with the solutions.
    fn solve_in_place(&mut self, columns: &mut [f64]) {
        match self {
            Self::Definite(factor) => factor.solve_in_place(columns),
            &mut Self::General(ref factor, n) => {
                // nalgebra underflows on systems of size zero
                if let Some(count) = columns.len().checked_div(n) {
                    factor.solve_mut(&mut DMatrixViewMut::from_slice(columns, n, count));
                }
            }
        }
    }
}

fn definite(factors: Vec<CoarseFactor>) -> Vec<Factor> {
    let boxed = factors.into_iter().map(Box::new);
    boxed.map(Factor::Definite).collect()
}

/// Largest matrix that is not symmetric and is factorised as a dense one.
const MAX_GENERAL_ROWS: usize = 4000;

/// `(K (x) I3)^-1` of three columns, one after the other.
fn solve_components(factors: &mut [Factor], columns: &mut [f64]) {
    let each = columns.len() / factors.len();
    for (factor, part) in factors
        .iter_mut()
        .zip(columns.chunks_exact_mut(each.max(1)))
    {
        factor.solve_in_place(part);
    }
}

/// `K + shift diag(K)`.
fn shift_diagonal(mut k: Csr, shift: f64) -> Csr {
    if shift > 0.0 {
        for (i, mut row) in k.outer_iterator_mut().enumerate() {
            for (j, value) in row.iter_mut() {
                if i == j {
                    *value += shift * *value;
                }
            }
        }
    }
    k
}

/// Converts one triple per node to three columns.
fn separate(interleaved: &[f64], components: &mut [f64]) {
    let n = components.len() / 3;
    for (i, triple) in interleaved.as_chunks::<3>().0.iter().enumerate() {
        for d in 0..3 {
            components[n * d + i] = triple[d];
        }
    }
}

/// Converts three columns to one triple per node.
fn interleave(components: &[f64], interleaved: &mut [f64]) {
    let n = components.len() / 3;
    for (i, triple) in interleaved.as_chunks_mut::<3>().0.iter_mut().enumerate() {
        for d in 0..3 {
            triple[d] = components[n * d + i];
        }
    }
}

/// Sparse factors of the coarsest scalar matrix.
#[cfg(feature = "direct")]
mod sparse {
    use std::borrow::Cow;

    use super::WHAT;
    use crate::csr::Rows;
    use crate::direct::{Definiteness, Precision, SparseFactor, nested_dissection};
    use crate::{Csr, LinalgError};

    /// Sparse Cholesky factors.
    pub struct CoarseFactor(SparseFactor);

    impl CoarseFactor {
        /// Factorises matrices with the sparsity pattern of `pattern`, one after the other.
        ///
        /// Each factor solves for `columns` right-hand sides at a time.
        ///
        /// # Errors
        /// [`LinalgError::Factorisation`] for a matrix that is not positive definite.
        pub fn all<'a>(
            pattern: &Csr,
            matrices: impl Iterator<Item = Cow<'a, Csr>>,
            columns: usize,
        ) -> Result<Vec<Self>, LinalgError> {
            let order = nested_dissection(&adjacency(pattern), &vec![1; pattern.rows()])?;
            let factorise = |k: Cow<Csr>| {
                let (definite, double) = (Definiteness::Positive, Precision::Double);
                let factor = SparseFactor::new(WHAT, &k, &order, definite, double, columns);
                factor.map(CoarseFactor)
            };
            matrices.map(factorise).collect()
        }

        /// Overwrites columns, one after another, with the solutions.
        pub fn solve_in_place(&mut self, columns: &mut [f64]) {
            self.0.solve_in_place(columns);
        }
    }

    /// Neighbours of each row, without the diagonal.
    fn adjacency(k: &Csr) -> Vec<Vec<u32>> {
        let rows = Rows::new(k);
        (0..k.rows())
            .map(|i| {
                rows.row(i)
                    .map(|(j, _)| j as u32)
                    .filter(|&j| j as usize != i)
                    .collect()
            })
            .collect()
    }
}

/// Dense factors of the coarsest scalar matrix.
#[cfg(not(feature = "direct"))]
mod dense {
    use std::borrow::Cow;

    use nalgebra::{Cholesky, DMatrix, DMatrixViewMut, Dyn};

    use super::WHAT;
    use crate::{Csr, LinalgError};

    /// Largest matrix that is factorised as a dense one, 130 MB.
    const MAX_DENSE_ROWS: usize = 4000;

    /// Dense Cholesky factors.
    pub struct CoarseFactor(Cholesky<f64, Dyn>);

    impl CoarseFactor {
        /// Factorises matrices one after the other.
        ///
        /// # Errors
        /// [`LinalgError::Factorisation`] for a matrix that is not positive definite, or too large
        /// to be stored as a dense one.
        pub fn all<'a>(
            _pattern: &Csr,
            matrices: impl Iterator<Item = Cow<'a, Csr>>,
            _columns: usize,
        ) -> Result<Vec<Self>, LinalgError> {
            matrices.map(|matrix| Self::new(&matrix)).collect()
        }

        fn new(matrix: &Csr) -> Result<Self, LinalgError> {
            let n = matrix.rows();
            let failed = |detail: String| LinalgError::Factorisation { what: WHAT, detail };
            if n > MAX_DENSE_ROWS {
                return Err(failed(format!(
                    "it has {n} rows, at most {MAX_DENSE_ROWS} without the feature `direct`"
                )));
            }
            let mut dense = DMatrix::zeros(n, n);
            for (value, (i, j)) in matrix.iter() {
                dense[(i as usize, j as usize)] = *value;
            }
            let factor = dense.cholesky();
            factor
                .map(CoarseFactor)
                .ok_or_else(|| failed("it is not positive definite".into()))
        }

        /// Overwrites columns, one after another, with the solutions.
        pub fn solve_in_place(&mut self, columns: &mut [f64]) {
            let n = self.0.l_dirty().nrows();
            // nalgebra underflows on systems of size zero
            if let Some(count) = columns.len().checked_div(n) {
                self.0
                    .solve_mut(&mut DMatrixViewMut::from_slice(columns, n, count));
            }
        }
    }
}
