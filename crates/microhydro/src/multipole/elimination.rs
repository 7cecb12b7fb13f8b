//! Schur complement on the rigid motions by one Cholesky factorisation.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::{cholesky_in_place, cholesky_in_place_scratch};
use faer::linalg::matmul::matmul;
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
    .map_err(|_| HydroError::FactorisationFailed {
        matrix: "Galerkin matrix",
        size,
    })?;
    let first = size - rigid;
    let corner = Mat::from_fn(rigid, rigid, |i, j| {
        if i < j {
            0.0
        } else {
            matrix[(first + i, first + j)]
        }
    });
    let full = gram(corner.as_ref(), par);
    let omitted = gram(matrix.submatrix(first, lower, rigid, first - lower), par);
    Ok([full.clone(), full + omitted])
}

/// `L L^T`.
fn gram(rows: MatRef<f64>, par: Par) -> DMatrix<f64> {
    let mut product = Mat::<f64>::zeros(rows.nrows(), rows.nrows());
    matmul(
        product.as_mut(),
        Accum::Replace,
        rows,
        rows.transpose(),
        1.0,
        par,
    );
    DMatrix::from_fn(rows.nrows(), rows.nrows(), |i, j| product[(i, j)])
}
