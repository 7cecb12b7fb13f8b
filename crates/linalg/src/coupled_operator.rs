//! A sparse matrix of 3 x 3 blocks as an operator.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;

use crate::bordered::{nodes, nodes_mut};
use crate::columns::{assert_lengths, in_passes};
use crate::csr::{
    Csr33, Rows, SYMMETRY_TOLERANCE, check_finite, check_shape, into_rows, to_blocks,
};
use crate::node_kernel::block_row;
use crate::product::build_rows;
use crate::row_blocks::RowBlocks;
use crate::{Csr, LinalgError, LinearOperator};

/// A sparse matrix of 3 x 3 blocks on vectors with three interleaved components per node.
///
/// For vector problems whose components are coupled: linear elasticity, or a viscous term
/// `∫ 2 mu D(u):D(v)` with variable viscosity. If the components are not coupled and have the same
/// matrix, [`Bordered::scalar`](crate::Bordered::scalar) reads a ninth of the memory. Square or
/// not; symmetry is measured, not assumed. Cloning shares the matrix.
///
/// Cost of [`apply`](LinearOperator::apply): one pass over the blocks of 76 bytes, two thirds of
/// the memory of the same scalar matrix; allocates nothing, and is bitwise the same on any number
/// of threads.
///
/// ```
/// use linalg::{CoupledOperator, Csr33, LinearOperator};
/// let a = [[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]];
/// let a = CoupledOperator::new(Csr33::new((1, 1), vec![0, 1], vec![0], vec![a]))?;
/// let mut y = [0.0; 3];
/// a.apply(&[1.0, 2.0, 4.0], &mut y);
/// assert_eq!(y, [0.0, -1.0, 6.0]);
/// assert!(a.is_symmetric());
/// # Ok::<(), linalg::LinalgError>(())
/// ```
#[derive(Debug, Clone)]
pub struct CoupledOperator {
    matrix: Arc<Csr33>,
    blocks: RowBlocks,
    symmetric: bool,
}

impl CoupledOperator {
    /// Wraps `matrix` after checking that its values are finite.
    ///
    /// # Errors
    /// [`LinalgError::NotFinite`].
    pub fn new(matrix: Csr33) -> Result<Self, LinalgError> {
        Self::with_symmetry(matrix, is_symmetric)
    }

    /// As [`CoupledOperator::new`] for a matrix that is symmetric by construction, without the
    /// search for the partner of each block.
    ///
    /// # Errors
    /// Those of [`CoupledOperator::new`]; [`LinalgError::Shape`] for a matrix that is not square.
    pub fn symmetric(matrix: Csr33) -> Result<Self, LinalgError> {
        let rows = matrix.rows();
        check_shape(
            "symmetric matrix of 3 x 3 blocks",
            matrix.shape(),
            (rows, rows),
        )?;
        Self::with_symmetry(matrix, |_| true)
    }

    fn with_symmetry(
        matrix: Csr33,
        is_symmetric: impl Fn(&Csr33) -> bool,
    ) -> Result<Self, LinalgError> {
        let values = matrix.data().as_flattened().as_flattened();
        check_finite("matrix of 3 x 3 blocks", values)?;
        let matrix = into_rows(matrix);
        Ok(CoupledOperator {
            blocks: RowBlocks::new(Rows::new(&matrix).indptr),
            symmetric: is_symmetric(&matrix),
            matrix: Arc::new(matrix),
        })
    }

    /// Collects the blocks of a matrix with three interleaved rows and columns per node.
    ///
    /// # Errors
    /// [`LinalgError::Shape`] if the rows or the columns are not a multiple of three,
    /// [`LinalgError::NotFinite`].
    pub fn from_interleaved(matrix: &Csr) -> Result<Self, LinalgError> {
        let whole = (matrix.rows() / 3 * 3, matrix.cols() / 3 * 3);
        check_shape("interleaved matrix of 3 x 3 blocks", matrix.shape(), whole)?;
        Self::new(to_blocks(&into_rows(matrix.clone()), |block| block))
    }

    /// The matrix of 3 x 3 blocks.
    pub fn matrix(&self) -> &Csr33 {
        &self.matrix
    }

    /// The scalar matrix with three interleaved rows and columns per node.
    pub fn to_interleaved(&self) -> Csr {
        let rows = Rows::new(&self.matrix);
        build_rows(self.rows(), self.cols(), |i, row| {
            for (j, block) in rows.row(i / 3) {
                for (c, value) in block[i % 3].into_iter().enumerate() {
                    row.add(3 * j + c, value);
                }
            }
        })
    }

    fn pass<const S: usize>(&self, x: [&[f64]; S], y: [&mut [f64]; S]) {
        assert_lengths(&x, self.cols(), &y, self.rows());
        let (matrix, x) = (Rows::new(&self.matrix), x.map(nodes));
        let rows = |rows: Range<usize>, mut y: [&mut [[f64; 3]]; S]| {
            for (at, i) in rows.enumerate() {
                for (y, sum) in y.iter_mut().zip(block_row(matrix, i, x)) {
                    y[at] = sum;
                }
            }
        };
        self.blocks.for_each_block(y.map(nodes_mut), &rows);
    }
}

impl LinearOperator for CoupledOperator {
    fn rows(&self) -> usize {
        3 * self.matrix.rows()
    }

    fn cols(&self) -> usize {
        3 * self.matrix.cols()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        self.pass([x], [y]);
    }

    fn apply_columns(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        in_passes!(self.pass(x, y));
    }

    /// Whether the matrix equals its transpose to rounding, as measured by
    /// [`CoupledOperator::new`].
    fn is_symmetric(&self) -> bool {
        self.symmetric
    }
}

/// Whether each block is the transpose of its partner to rounding; an absent block is zero.
fn is_symmetric(matrix: &Csr33) -> bool {
    if matrix.rows() != matrix.cols() {
        return false;
    }
    let rows = Rows::new(matrix);
    let largest = |i: usize| {
        let diagonal = rows.entry(i, i);
        (0..3).fold(0.0_f64, |m, d| m.max(diagonal[d][d].abs()))
    };
    (0..matrix.rows()).into_par_iter().all(|i| {
        rows.row(i).all(|(j, a)| {
            let (b, size) = (rows.entry(j, i), largest(i).max(largest(j)));
            (0..9).all(|k| {
                let (a, b) = (a[k / 3][k % 3], b[k % 3][k / 3]);
                (a - b).abs() <= SYMMETRY_TOLERANCE * size.max(a.abs())
            })
        })
    })
}
