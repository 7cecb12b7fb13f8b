//! What the solver needs to know about the rows of the pressure.

use crate::PetscError;
use crate::handles::{Matrix, Rows, Session, Vector};

/// Multiple of the mass matrix in the Schur complement of a weak row, as in `linalg`.
const WEAK: f64 = 4.0;

/// A square matrix without nonzeros.
pub fn no_entries<'s>(session: &'s Session, size: usize) -> Result<Matrix<'s>, PetscError> {
    let mut rows = Rows::default();
    for _ in 0..size {
        rows.end_row()?;
    }
    Matrix::from_rows(session, &rows, size)
}

/// Unit vector of the constant pressure in the scaled system.
pub fn null_vector<'s>(
    session: &'s Session,
    [motion, pressure]: &[Vec<f64>; 2],
) -> Result<Vector<'s>, PetscError> {
    let mut constant = vec![0.0; motion.len()];
    constant.extend(pressure.iter().map(|factor| factor.recip()));
    let norm = Vector::from_slice(session, &constant)?.norm()?;
    constant.iter_mut().for_each(|value| *value /= norm);
    Vector::from_slice(session, &constant)
}

/// Diagonal `-W` that is added to the inverse of the negative mass matrix at edges and corners.
///
/// `W = max(0, 1 / (4 s) - 1 / m)` with `s = (B D^-1 B^T)_qq` and the diagonal `m` of the mass
/// matrix, as in `linalg`. In the scaled system `m` is one and `s` is the squared norm of a row of
/// `B`. The sign is that of the Schur complement.
pub fn weak_rows(divergence: &Matrix) -> Result<Vec<f64>, PetscError> {
    let mut weak = Vec::new();
    divergence.for_each_row(|_, values| {
        let schur: f64 = values.iter().map(|value| value * value).sum();
        let excess = (WEAK * schur).recip() - 1.0;
        // A row without free velocities has no Schur complement to approximate.
        let is_weak = excess > 0.0 && excess.is_finite();
        weak.push(if is_weak { -excess } else { 0.0 });
    })?;
    Ok(weak)
}
