//! Schur complements and inverses of symmetric matrices by one Cholesky factorisation.

use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::cholesky::llt::inverse::{inverse as inverse_from_factor, inverse_scratch};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatRef, Par, Spec};
use nalgebra::DMatrix;

use crate::HydroError;

/// Number of degrees of freedom below which threads cost more than they save.
const MIN_DOFS_FOR_THREADS: usize = 500;

/// Schur complements on the last `rigid` rows: of the full matrix, and of a part of it.
///
/// The part is the matrix of the lower order: it has the first `lower` rows and the rigid ones. The
/// symmetric positive definite `matrix` is read on and below its diagonal. With `A = L L^T` the
/// first complement is `L_rr L_rr^T`, where `r` are the rigid rows. The second one is
/// `L_rr L_rr^T + L_ro L_ro^T`, where `o` are the rows that the part omits. One factorisation thus
/// gives both complements, without a small difference of large numbers. Cost: `n^3/3`.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
pub(super) fn eliminate(
    mut matrix: Mat<f64>,
    rigid: usize,
    lower: usize,
) -> Result<[DMatrix<f64>; 2], HydroError> {
    let par = factor(&mut matrix)?;
    let first = matrix.nrows() - rigid;
    let full = complement(&matrix, rigid, par);
    let lower = &full + omitted(&matrix, rigid, lower..first, par);
    Ok([full, lower])
}

/// Schur complements of `matrix` on its last rows: for two numbers of rows, and on the first of
/// these without the columns `left_out` before them, as in [`eliminate`].
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
pub(super) fn complements(
    mut matrix: Mat<f64>,
    rows: [usize; 2],
    left_out: Range<usize>,
) -> Result<[DMatrix<f64>; 3], HydroError> {
    let par = factor(&mut matrix)?;
    let [first, second] = rows.map(|rows| complement(&matrix, rows, par));
    let without = &first + omitted(&matrix, rows[0], left_out, par);
    Ok([first, second, without])
}

/// Schur complement of `matrix` on its last rows.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
pub(super) fn schur_complement(
    mut matrix: Mat<f64>,
    rows: usize,
) -> Result<DMatrix<f64>, HydroError> {
    let par = factor(&mut matrix)?;
    Ok(complement(&matrix, rows, par))
}

/// Inverse of a symmetric positive definite matrix; `name` is its name in errors.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
pub(crate) fn inverse(
    matrix: &DMatrix<f64>,
    name: &'static str,
) -> Result<DMatrix<f64>, HydroError> {
    let size = matrix.nrows();
    let mut factor = Mat::from_fn(size, size, |i, j| matrix[(i, j)]);
    let par = factor_in_place(&mut factor, name)?;
    let mut memory = MemBuffer::new(inverse_scratch::<f64>(size, par));
    let mut inverse = Mat::<f64>::zeros(size, size);
    inverse_from_factor(
        inverse.as_mut(),
        factor.as_ref(),
        par,
        MemStack::new(&mut memory),
    );
    Ok(symmetric(&inverse))
}

/// The symmetric matrix with the given lower triangle.
fn symmetric(lower: &Mat<f64>) -> DMatrix<f64> {
    let size = lower.nrows();
    DMatrix::from_fn(size, size, |i, j| lower[(i.max(j), i.min(j))])
}

/// Cholesky factor of a Galerkin matrix, in its lower triangle, and the number of threads used.
fn factor(matrix: &mut Mat<f64>) -> Result<Par, HydroError> {
    factor_in_place(matrix, "Galerkin matrix")
}

fn factor_in_place(matrix: &mut Mat<f64>, name: &'static str) -> Result<Par, HydroError> {
    let size = matrix.nrows();
    // a fixed number of threads, so that the result does not depend on how many there are
    let par = match size < MIN_DOFS_FOR_THREADS {
        true => Par::Seq,
        false => Par::rayon(2),
    };
    let mut memory = MemBuffer::new(cholesky_in_place_scratch::<f64>(size, par, Spec::default()));
    cholesky_in_place(
        matrix.as_mut(),
        Default::default(),
        par,
        MemStack::new(&mut memory),
        Spec::default(),
    )
    .map_err(|_| HydroError::FactorisationFailed { matrix: name, size })?;
    Ok(par)
}

/// `L_rr L_rr^T` for the last rows `r` of a Cholesky factor.
fn complement(factor: &Mat<f64>, rows: usize, par: Par) -> DMatrix<f64> {
    let first = factor.nrows() - rows;
    let corner = factor.submatrix(first, first, rows, rows);
    let triangles = (
        BlockStructure::TriangularLower,
        BlockStructure::TriangularUpper,
    );
    product(corner, triangles, par)
}

/// `L_ro L_ro^T` for the last rows `r` and some columns `o` of a Cholesky factor.
fn omitted(factor: &Mat<f64>, rows: usize, columns: Range<usize>, par: Par) -> DMatrix<f64> {
    let first = factor.nrows() - rows;
    let part = factor.submatrix(first, columns.start, rows, columns.len());
    let rectangles = (BlockStructure::Rectangular, BlockStructure::Rectangular);
    product(part, rectangles, par)
}

/// `L L^T`, where only the given parts of the two factors are read.
fn product(
    rows: MatRef<f64>,
    (left, right): (BlockStructure, BlockStructure),
    par: Par,
) -> DMatrix<f64> {
    let mut product = Mat::<f64>::zeros(rows.nrows(), rows.nrows());
    matmul(
        product.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Replace,
        rows,
        left,
        rows.transpose(),
        right,
        1.0,
        par,
    );
    symmetric(&product)
}
