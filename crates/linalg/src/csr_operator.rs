//! A sparse matrix as an operator on vectors with one component per row.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::columns::{assert_lengths, in_passes};
use crate::csr::{Rows, SYMMETRY_TOLERANCE, check_finite, diagonal, into_rows};
use crate::row_blocks::RowBlocks;
use crate::{Csr, LinalgError, LinearOperator};

/// A sparse matrix `A` as a [`LinearOperator`]: `y = A x`, one number per row.
///
/// For systems with one component, such as a scalar Poisson problem. Three right-hand sides of the
/// same symmetric matrix are solved faster as one [`Bordered::scalar`](crate::Bordered::scalar).
/// The symmetry of `A` is checked entry by entry, not assumed. Cloning shares the matrix.
///
/// Cost of [`apply`](LinearOperator::apply): one pass over `A`; allocates nothing, and is bitwise
/// the same on any number of threads.
///
/// ```
/// use linalg::{Csr, CsrOperator, LinearOperator};
/// let a = Csr::new((2, 2), vec![0, 2, 4], vec![0, 1, 0, 1], vec![2.0, -1.0, -1.0, 2.0]);
/// let a = CsrOperator::new(a)?;
/// let mut y = [0.0; 2];
/// a.apply(&[1.0, 3.0], &mut y);
/// assert_eq!(y, [-1.0, 5.0]);
/// assert!(a.is_symmetric());
/// # Ok::<(), linalg::LinalgError>(())
/// ```
#[derive(Debug, Clone)]
pub struct CsrOperator {
    matrix: Arc<Csr>,
    blocks: RowBlocks,
    symmetric: bool,
}

impl CsrOperator {
    /// Wraps `matrix` after checking that its values are finite.
    ///
    /// # Errors
    /// [`LinalgError::NotFinite`].
    pub fn new(matrix: Csr) -> Result<Self, LinalgError> {
        check_finite("sparse matrix", matrix.data())?;
        let matrix = into_rows(matrix);
        Ok(CsrOperator {
            blocks: RowBlocks::new(Rows::new(&matrix).indptr),
            symmetric: is_symmetric(&matrix),
            matrix: Arc::new(matrix),
        })
    }

    /// The matrix.
    pub fn matrix(&self) -> &Csr {
        &self.matrix
    }

    /// The matrix, for a preconditioner that keeps its pattern.
    pub(crate) fn shared_matrix(&self) -> &Arc<Csr> {
        &self.matrix
    }

    fn pass<const S: usize>(&self, x: [&[f64]; S], y: [&mut [f64]; S]) {
        assert_lengths(&x, self.cols(), &y, self.rows());
        let matrix = Rows::new(&self.matrix);
        let rows = |rows: Range<usize>, mut y: [&mut [f64]; S]| {
            for (at, i) in rows.enumerate() {
                let mut sums = [0.0; S];
                for (j, a) in matrix.row(i) {
                    for (sum, x) in sums.iter_mut().zip(x) {
                        *sum += a * x[j];
                    }
                }
                for (y, sum) in y.iter_mut().zip(sums) {
                    y[at] = sum;
                }
            }
        };
        self.blocks.for_each_block(y, &rows);
    }
}

impl LinearOperator for CsrOperator {
    fn rows(&self) -> usize {
        self.matrix.rows()
    }

    fn cols(&self) -> usize {
        self.matrix.cols()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.pass([x], [y]);
    }

    fn apply_columns(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        in_passes!(self.pass(x, y));
    }

    /// Whether the matrix equals its transpose to rounding, as measured by [`CsrOperator::new`].
    fn is_symmetric(&self) -> bool {
        self.symmetric
    }
}

/// Whether `a_ij = a_ji` to rounding for all stored entries; an absent entry is zero.
fn is_symmetric(matrix: &Csr) -> bool {
    if matrix.rows() != matrix.cols() {
        return false;
    }
    let (rows, diagonal) = (Rows::new(matrix), diagonal(matrix));
    (0..matrix.rows()).into_par_iter().all(|i| {
        rows.row(i).all(|(j, a)| {
            let size = diagonal[i].abs().max(diagonal[j].abs()).max(a.abs());
            (a - rows.entry(j, i)).abs() <= SYMMETRY_TOLERANCE * size
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn operator(shape: (usize, usize), starts: Vec<usize>, columns: Vec<u32>) -> CsrOperator {
        let values = (0..columns.len()).map(|k| k as f64 + 1.0).collect();
        CsrOperator::new(Csr::new(shape, starts, columns, values)).expect("finite values")
    }

    #[test]
    fn symmetry_is_measured() {
        // [1 2; 0 3], [1 2 3], and a diagonal
        assert!(!operator((2, 2), vec![0, 2, 3], vec![0, 1, 1]).is_symmetric());
        assert!(!operator((1, 3), vec![0, 3], vec![0, 1, 2]).is_symmetric());
        assert!(operator((2, 2), vec![0, 1, 2], vec![0, 1]).is_symmetric());
    }

    #[test]
    fn several_columns_equal_each_alone() {
        let a = operator((2, 3), vec![0, 2, 3], vec![0, 2, 1]);
        let x: [&[f64]; 2] = [&[1.0, 10.0, 100.0], &[2.0, 0.0, 1.0]];
        let (mut y, mut z) = ([0.0; 2], [0.0; 2]);
        a.apply_columns(&x, &mut [&mut y, &mut z]);
        assert_eq!((y, z), ([201.0, 30.0], [4.0, 0.0]));
    }

    #[test]
    fn values_that_are_not_finite_are_refused() {
        let matrix = Csr::new((1, 1), vec![0, 1], vec![0], vec![f64::NAN]);
        let refused = CsrOperator::new(matrix).map(|_| ());
        assert!(matches!(refused, Err(LinalgError::NotFinite { .. })));
    }
}
