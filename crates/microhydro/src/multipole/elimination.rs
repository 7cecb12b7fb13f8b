//! Schur complements and inverses of symmetric matrices by one Cholesky factorisation.

use std::ops::Range;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::cholesky::llt::inverse::{inverse as inverse_from_factor, inverse_scratch};
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::linalg::triangular_solve::solve_lower_triangular_in_place;
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
    matrix: Mat<f64>,
    rigid: usize,
    lower: usize,
) -> Result<[DMatrix<f64>; 2], HydroError> {
    let first = matrix.nrows() - rigid;
    let factor = GalerkinFactor::new(matrix)?;
    let full = factor.complement(rigid);
    let lower = &full + factor.omitted(rigid, lower..first);
    Ok([full, lower])
}

/// Schur complement of `matrix` on its last rows.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
pub(super) fn schur_complement(matrix: Mat<f64>, rows: usize) -> Result<DMatrix<f64>, HydroError> {
    Ok(GalerkinFactor::new(matrix)?.complement(rows))
}

/// Subtracts `C C^T` from the lower triangle of a symmetric matrix.
pub(super) fn subtract_square(matrix: &mut Mat<f64>, columns: MatRef<f64>) {
    let par = parallelism(matrix.nrows());
    matmul(
        matrix.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Add,
        columns,
        BlockStructure::Rectangular,
        columns.transpose(),
        BlockStructure::Rectangular,
        -1.0,
        par,
    );
}

/// Replaces `C` by `C L^-T` with the Cholesky factor `L` of a symmetric positive definite matrix,
/// read on and below its diagonal: `C C^T` is then `C A^-1 C^T`.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
pub(super) fn divide_by_factor(
    columns: &mut Mat<f64>,
    mut matrix: Mat<f64>,
) -> Result<(), HydroError> {
    let par = factor_in_place(&mut matrix, "Galerkin matrix")?;
    solve_lower_triangular_in_place(matrix.as_ref(), columns.as_mut().transpose_mut(), par);
    Ok(())
}

/// Cholesky factor `L` of a Galerkin matrix, from which Schur complements are products.
pub(super) struct GalerkinFactor {
    /// The factor, in the lower triangle.
    lower: Mat<f64>,
    /// Number of threads of products.
    par: Par,
}

impl GalerkinFactor {
    /// Factorises the symmetric positive definite `matrix`, read on and below its diagonal. Cost:
    /// `n^3/3`.
    ///
    /// # Errors
    /// [`HydroError::FactorisationFailed`].
    pub fn new(mut matrix: Mat<f64>) -> Result<Self, HydroError> {
        let par = factor_in_place(&mut matrix, "Galerkin matrix")?;
        Ok(Self { lower: matrix, par })
    }

    /// The Schur complement on the last `rows`: `L_rr L_rr^T` with these rows `r`.
    pub fn complement(&self, rows: usize) -> DMatrix<f64> {
        let first = self.lower.nrows() - rows;
        let corner = self.lower.submatrix(first, first, rows, rows);
        let triangles = (
            BlockStructure::TriangularLower,
            BlockStructure::TriangularUpper,
        );
        product(corner, triangles, self.par)
    }

    /// What the complement on the last `rows` gains without the columns `o` directly before them,
    /// as in [`eliminate`]: `L_ro L_ro^T`.
    pub fn omitted(&self, rows: usize, columns: Range<usize>) -> DMatrix<f64> {
        let first = self.lower.nrows() - rows;
        let part = self
            .lower
            .submatrix(first, columns.start, rows, columns.len());
        let rectangles = (BlockStructure::Rectangular, BlockStructure::Rectangular);
        product(part, rectangles, self.par)
    }
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

/// Replaces a matrix by its Cholesky factor, in the lower triangle; returns the number of threads.
fn factor_in_place(matrix: &mut Mat<f64>, name: &'static str) -> Result<Par, HydroError> {
    let size = matrix.nrows();
    let par = parallelism(size);
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

/// A fixed number of threads, so that the result does not depend on how many there are.
fn parallelism(size: usize) -> Par {
    match size < MIN_DOFS_FOR_THREADS {
        true => Par::Seq,
        false => Par::rayon(2),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Against Schur complements by inverse matrices, of the whole matrix and without some columns.
    #[test]
    fn complements_are_those_of_the_matrix_with_and_without_columns() {
        let (size, rows) = (7, 2);
        let entry = |i: usize, j: usize| {
            let diagonal = if i == j { 3.0 } else { 0.0 };
            diagonal + 1.0 / (1.0 + i as f64 + j as f64)
        };
        let factor = GalerkinFactor::new(Mat::from_fn(size, size, entry)).unwrap();
        let exact = |eliminated: usize| {
            let part = |rows: Range<usize>, columns: Range<usize>| {
                DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
                    entry(rows.start + i, columns.start + j)
                })
            };
            let (high, low) = (0..eliminated, size - rows..size);
            let inverse = part(high.clone(), high.clone()).try_inverse().unwrap();
            let coupling = part(low.clone(), high);
            part(low.clone(), low) - &coupling * inverse * coupling.transpose()
        };
        let whole = factor.complement(rows);
        assert!((&whole - exact(5)).amax() < 1e-14);
        assert!((whole + factor.omitted(rows, 3..5) - exact(3)).amax() < 1e-14);
    }
}
