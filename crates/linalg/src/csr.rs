//! The compressed-row matrix types that crates exchange, and kernels on their arrays.

use std::sync::Arc;

use rayon::prelude::*;
use sprs::CsMatI;

use crate::LinalgError;
use crate::vector::{CHUNK, map_rows};

/// Sparse matrix in compressed rows.
///
/// Columns are `u32` and sorted in each row, row pointers `usize`.
///
/// The interchange type of all public functions; sprs keeps the structure valid.
pub type Csr = CsMatI<f64, u32, usize>;

/// Sparse matrix in compressed rows whose entries are 3-vectors.
///
/// Row `q`, column `j` stores `(b_x, b_y, b_z)`.
///
/// The discrete divergence has this form: `(B u)_q = sum_j b_qj · u_j`, with one row per pressure
/// dof and one column per velocity node.
pub type Csr3 = CsMatI<[f64; 3], u32, usize>;

/// Sparse matrix in compressed rows whose entries are 3 x 3 blocks, each by rows.
///
/// Entry `(i, j)` couples the components of nodes `i` and `j`: `(A u)_i = sum_j A_ij u_j`.
pub type Csr33 = CsMatI<[[f64; 3]; 3], u32, usize>;

/// Sparse matrix in f32 for preconditioners: half the bytes, hence twice the speed.
pub(crate) type Csr32 = CsMatI<f32, u32, usize>;

/// Relative difference up to which `a_ij` and `a_ji` count as equal.
///
/// Assembly sums the two in different orders, which leaves a few roundings.
pub(crate) const SYMMETRY_TOLERANCE: f64 = 1e3 * f64::EPSILON;

/// The arrays of a sparse matrix, borrowed once so that kernels index plain slices.
pub(crate) struct Rows<'a, V> {
    pub indptr: &'a [usize],
    columns: &'a [u32],
    values: &'a [V],
}

// a derived `Copy` would require `V: Copy`, which references do not need
impl<V> Clone for Rows<'_, V> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<V> Copy for Rows<'_, V> {}

impl<'a, V: Copy> Rows<'a, V> {
    pub fn new(matrix: &'a CsMatI<V, u32, usize>) -> Self {
        Rows {
            indptr: matrix.indptr().into_raw_storage(),
            columns: matrix.indices(),
            values: matrix.data(),
        }
    }

    /// Number of nonzeros.
    pub fn nnz(self) -> usize {
        self.values.len()
    }

    /// Columns and values of row `i`.
    #[inline(always)]
    pub fn entries(self, i: usize) -> (&'a [u32], &'a [V]) {
        let range = self.indptr[i]..self.indptr[i + 1];
        (&self.columns[range.clone()], &self.values[range])
    }

    /// Entry `(i, j)`; an absent one is zero.
    pub fn entry(self, i: usize, j: usize) -> V
    where
        V: Default,
    {
        let (columns, values) = self.entries(i);
        let place = columns.binary_search(&(j as u32));
        place.map_or(V::default(), |place| values[place])
    }

    /// The (column, value) pairs of row `i` in ascending order of columns.
    #[inline(always)]
    pub fn row(self, i: usize) -> impl Iterator<Item = (usize, V)> + 'a {
        let (columns, values) = self.entries(i);
        columns.iter().zip(values).map(|(&j, &v)| (j as usize, v))
    }
}

/// Converts a matrix to storage by rows; sprs also stores matrices by columns.
pub(crate) fn into_rows<V: Clone + Default>(
    matrix: CsMatI<V, u32, usize>,
) -> CsMatI<V, u32, usize> {
    matrix.into_csr()
}

/// A matrix without nonzeros.
pub(crate) fn empty<V>(rows: usize, cols: usize) -> CsMatI<V, u32, usize> {
    CsMatI::new((rows, cols), vec![0; rows + 1], Vec::new(), Vec::new())
}

/// The 3 x 3 blocks of a matrix with three interleaved rows and columns per node.
pub(crate) fn to_blocks<T: Clone>(
    matrix: &Csr,
    convert: impl Fn([[f64; 3]; 3]) -> T,
) -> CsMatI<T, u32, usize> {
    let rows = Rows::new(matrix);
    let (mut starts, mut columns, mut blocks) = (vec![0], Vec::new(), Vec::new());
    for node in 0..matrix.rows() / 3 {
        let mut places = [0; 3];
        let entries: [_; 3] = std::array::from_fn(|d| rows.entries(3 * node + d));
        // merges three ascending lists
        while let Some(j) = (0..3)
            .filter_map(|d| entries[d].0.get(places[d]).map(|column| column / 3))
            .min()
        {
            let mut block = [[0.0; 3]; 3];
            for d in 0..3 {
                let (row, values) = entries[d];
                while row.get(places[d]).is_some_and(|column| column / 3 == j) {
                    block[d][row[places[d]] as usize % 3] = values[places[d]];
                    places[d] += 1;
                }
            }
            columns.push(j);
            blocks.push(convert(block));
        }
        starts.push(columns.len());
    }
    CsMatI::new(
        (matrix.rows() / 3, matrix.cols() / 3),
        starts,
        columns,
        blocks,
    )
}

/// Scales by `factor` and rounds to the precision of preconditioners.
pub(crate) fn to_f32(matrix: &Csr, factor: f64) -> Csr32 {
    matrix.map(|&v| (v * factor) as f32)
}

/// Values of a matrix in f32, with the sparsity pattern of the original.
///
/// Half the memory of a copy with column indices.
pub(crate) struct Rounded {
    pattern: Arc<Csr>,
    values: Vec<f32>,
}

impl Rounded {
    /// Rounds `factor` times `matrix`.
    pub fn new(matrix: &Arc<Csr>, factor: f64) -> Self {
        let values = matrix.data().par_iter();
        Rounded {
            pattern: Arc::clone(matrix),
            values: values.map(|&v| (v * factor) as f32).collect(),
        }
    }

    pub fn borrow(&self) -> Rows<'_, f32> {
        Rows {
            indptr: self.pattern.indptr().into_raw_storage(),
            columns: self.pattern.indices(),
            values: &self.values,
        }
    }
}

pub(crate) fn check_shape(
    what: &'static str,
    found: (usize, usize),
    expected: (usize, usize),
) -> Result<(), LinalgError> {
    if found == expected {
        return Ok(());
    }
    Err(LinalgError::Shape {
        what,
        expected,
        found,
    })
}

/// Refuses NaN and infinity, naming the position.
pub(crate) fn check_finite(what: &'static str, values: &[f64]) -> Result<(), LinalgError> {
    // no early exit, so that the loop is vectorised
    let finite = |chunk: &[f64]| chunk.iter().fold(true, |all, v| all & v.is_finite());
    if values.par_chunks(CHUNK).all(finite) {
        return Ok(());
    }
    let index = values.iter().position(|v| !v.is_finite()).unwrap_or(0);
    Err(LinalgError::NotFinite { what, index })
}

/// The diagonal of a square matrix; an absent entry is zero.
pub(crate) fn diagonal(matrix: &Csr) -> Vec<f64> {
    let rows = Rows::new(matrix);
    map_rows(matrix.rows(), &|i| rows.entry(i, i))
}

/// The diagonal of a matrix; an entry that is not positive is an error.
///
/// Jacobi smoothing divides by it.
pub(crate) fn positive_diagonal(what: &'static str, matrix: &Csr) -> Result<Vec<f64>, LinalgError> {
    let diagonal = diagonal(matrix);
    match diagonal.iter().position(|d| d.is_nan() || *d <= 0.0) {
        Some(row) => Err(LinalgError::NotPositive {
            what,
            row,
            value: diagonal[row],
        }),
        None => Ok(diagonal),
    }
}
