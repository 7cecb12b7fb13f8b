//! The compressed-row types every crate exchanges: scalar entries and 3-vector entries.

use sprs::CsMatI;

use crate::LinalgError;

/// Compressed sparse rows: `u32` columns, `usize` row pointers, columns sorted within a row.
///
/// The interchange type of the workspace; sprs keeps the structure valid (sorted, in bounds).
pub type Csr = CsMatI<f64, u32, usize>;

/// Compressed sparse rows whose entries are 3-vectors: row `q`, column `j` holds `(b_x, b_y, b_z)`.
///
/// The discrete divergence has this form: `(B u)_q = sum_j b_qj . u_j`, one row a pressure
/// unknown, one column a velocity node.
pub type Csr3 = CsMatI<[f64; 3], u32, usize>;

/// A compressed-row matrix of the preconditioner: half the bytes, which is twice the speed.
pub(crate) type Csr32 = CsMatI<f32, u32, usize>;

/// The three arrays of a compressed-row matrix, borrowed once so that kernels index plain slices.
pub(crate) struct Rows<'a, V> {
    pub indptr: &'a [usize],
    columns: &'a [u32],
    values: &'a [V],
}

// Derived `Copy` would ask for `V: Copy`, which references do not need.
impl<V> Clone for Rows<'_, V> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<V> Copy for Rows<'_, V> {}

impl<'a, V: Copy> Rows<'a, V> {
    pub fn of(matrix: &'a CsMatI<V, u32, usize>) -> Self {
        Rows {
            indptr: matrix.indptr().into_raw_storage(),
            columns: matrix.indices(),
            values: matrix.data(),
        }
    }

    /// The (column, value) pairs of row `i`, columns rising.
    #[inline(always)]
    pub fn row(self, i: usize) -> impl Iterator<Item = (usize, V)> + 'a {
        let range = self.indptr[i]..self.indptr[i + 1];
        let values = &self.values[range.clone()];
        self.columns[range]
            .iter()
            .zip(values)
            .map(|(&j, &v)| (j as usize, v))
    }
}

/// `matrix` by rows: a `CsMatI` may also hold columns.
pub(crate) fn into_rows<V: Clone + Default>(
    matrix: CsMatI<V, u32, usize>,
) -> CsMatI<V, u32, usize> {
    matrix.into_csr()
}

/// The transpose, stored by rows.
pub(crate) fn transpose<V: Clone + Default>(
    matrix: &CsMatI<V, u32, usize>,
) -> CsMatI<V, u32, usize> {
    matrix.transpose_view().to_csr()
}

/// A matrix without entries.
pub(crate) fn empty<V>(rows: usize, cols: usize) -> CsMatI<V, u32, usize> {
    CsMatI::new((rows, cols), vec![0; rows + 1], Vec::new(), Vec::new())
}

/// Rounds to the precision of the preconditioner after scaling by `factor`.
pub(crate) fn to_f32(matrix: &Csr, factor: f64) -> Csr32 {
    matrix.map(|&v| (v * factor) as f32)
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

/// Refuses NaN and infinity, naming the place.
pub(crate) fn check_finite<'a>(
    what: &'static str,
    values: impl IntoIterator<Item = &'a f64>,
) -> Result<(), LinalgError> {
    match values.into_iter().position(|v| !v.is_finite()) {
        Some(index) => Err(LinalgError::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// The diagonal of a square matrix; an absent entry is zero.
pub(crate) fn diagonal(matrix: &Csr) -> Vec<f64> {
    let rows = Rows::of(matrix);
    (0..matrix.rows())
        .map(|i| rows.row(i).find(|&(j, _)| j == i).map_or(0.0, |(_, v)| v))
        .collect()
}

/// The diagonal, refused unless every entry is positive: Jacobi smoothing divides by it.
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
