//! The dense Schur complement of the border.

use nalgebra::{DMatrix, DVector, Dyn, LU, SymmetricEigen};

use crate::LinalgError;
use crate::csr::check_finite;

/// Pivoted LU factors of the border's Schur complement.
///
/// Pivoting admits borders with constraints (zeros on the diagonal) and nonsymmetric ones.
pub(crate) struct SchurFactor(LU<f64, Dyn, Dyn>);

impl SchurFactor {
    /// Factorises `schur`; a matrix that is singular to working precision is an error.
    pub fn new(schur: DMatrix<f64>) -> Result<Self, LinalgError> {
        let m = schur.nrows();
        let lu = schur.lu();
        let pivots = lu.u().diagonal().abs();
        let (smallest, largest) = (pivots.min(), pivots.max());
        // a pivot below m epsilon relative to the largest is rounding error
        let sound = smallest > m as f64 * f64::EPSILON * largest && largest.is_finite();
        if m > 0 && !sound {
            return Err(LinalgError::Factorisation {
                what: "Schur complement of the border",
                detail: format!(
                    "pivots from {smallest:e} to {largest:e}; look for border dofs with the same motion, or redundant constraints"
                ),
            });
        }
        Ok(SchurFactor(lu))
    }

    /// Factors of `|S| = Q diag(|s|) Q^T` for a symmetric `S = Q diag(s) Q^T`.
    pub fn absolute(schur: DMatrix<f64>) -> Result<Self, LinalgError> {
        check_finite("Schur complement of the border", schur.as_slice())?;
        // nalgebra panics on matrices of size zero
        if schur.is_empty() {
            return Self::new(schur);
        }
        let SymmetricEigen {
            eigenvalues,
            eigenvectors: q,
        } = schur.symmetric_eigen();
        Self::new(&q * DMatrix::from_diagonal(&eigenvalues.abs()) * q.transpose())
    }

    /// Overwrites `v` with the solution.
    pub fn solve(&self, v: &mut DVector<f64>) {
        // nalgebra underflows for size zero; all other factors are known to be invertible
        if !v.is_empty() {
            self.0.solve_mut(v);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indefinite_is_accepted_singular_is_refused() {
        let constrained = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 1.0, 0.0]);
        let mut v = DVector::from_column_slice(&[3.0, 4.0]);
        SchurFactor::new(constrained)
            .expect("regular")
            .solve(&mut v);
        assert_eq!(v.as_slice(), [4.0, 3.0]);
        let singular = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 4.0]);
        for refused in [singular, DMatrix::from_element(1, 1, f64::NAN)] {
            let error = SchurFactor::new(refused).map(|_| ());
            assert!(matches!(error, Err(LinalgError::Factorisation { .. })));
        }
    }

    #[test]
    fn absolute_value_of_a_matrix() {
        // the eigenvalues are 1 and -1: the absolute value is the identity
        let constrained = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, 1.0, 0.0]);
        let factor = SchurFactor::absolute(constrained).expect("regular");
        let mut v = DVector::from_column_slice(&[3.0, 4.0]);
        factor.solve(&mut v);
        assert!((v - DVector::from_column_slice(&[3.0, 4.0])).amax() < 1e-14);
        assert!(SchurFactor::absolute(DMatrix::zeros(1, 1)).is_err());
        assert!(SchurFactor::absolute(DMatrix::from_element(1, 1, f64::NAN)).is_err());
        assert!(SchurFactor::absolute(DMatrix::zeros(0, 0)).is_ok());
    }

    #[test]
    fn bug_a_system_without_border_made_the_coarse_solve_panic() {
        let factor = SchurFactor::new(DMatrix::zeros(0, 0)).expect("nothing to refuse");
        factor.solve(&mut DVector::zeros(0));
    }
}
