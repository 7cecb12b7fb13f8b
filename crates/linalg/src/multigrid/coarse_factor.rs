//! Factors of the coarsest scalar matrix: sparse with the feature `direct`, dense without.

#[cfg(feature = "direct")]
pub(super) use sparse::CoarseFactor;

#[cfg(not(feature = "direct"))]
pub(super) use dense::CoarseFactor;

const WHAT: &str = "coarsest stiffness matrix";

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
        let rows = Rows::of(k);
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

#[cfg(not(feature = "direct"))]
mod dense {
    use std::borrow::Cow;

    use nalgebra::{Cholesky, DMatrix, DMatrixViewMut, Dyn};

    use super::WHAT;
    use crate::{Csr, LinalgError};

    /// Largest matrix that is factorised as a dense one, 130 MB.
    const MOST_ROWS: usize = 4000;

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
            if n > MOST_ROWS {
                return Err(failed(format!(
                    "it has {n} rows, at most {MOST_ROWS} without the feature `direct`"
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
