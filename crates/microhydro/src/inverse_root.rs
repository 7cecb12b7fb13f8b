//! Inverse square roots of operators times vectors, by the method of Lanczos.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use crate::HydroError;

/// Change of the result by the last step, relative to it, at which the iteration stops: random
/// forces then have their covariance to this accuracy.
pub(crate) const TOLERANCE: f64 = 1e-6;

/// Largest number of steps: each vector of the basis is kept.
const MAX_STEPS: usize = 300;

/// Norm of a new vector of the basis, relative to the product of the step, that is rounding.
const BREAKDOWN: f64 = 1e-14;

/// `A^(-1/2) w` for a symmetric positive definite operator `A`, which `apply` multiplies with
/// vectors; `None` for an operator that is not positive definite.
///
/// With the orthonormal basis `V` of the Krylov space of `w` and `T = V^T A V`, tridiagonal, the
/// result after each step is `|w| V T^(-1/2) e_1` (Chow & Saad 2014, SIAM J. Sci. Comput. 36, A588;
/// stopped as by Ando et al. 2012, J. Chem. Phys. 137, 064106). It converges like conjugate
/// gradients. Cost of `m` steps: `m` products, `2 m²` products of vectors for a basis that stays
/// orthogonal. Sums have a fixed order: the result does not depend on the number of threads.
///
/// # Errors
/// [`HydroError::RootNotConverged`]; those of `apply`.
pub(crate) fn inverse_root(
    w: &DVector<f64>,
    apply: impl Fn(&DVector<f64>) -> Result<DVector<f64>, HydroError>,
) -> Result<Option<DVector<f64>>, HydroError> {
    let norm = w.norm();
    if norm == 0.0 {
        return Ok(Some(w.clone()));
    }
    let mut basis = vec![w / norm];
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    let mut last = DVector::zeros(0);
    let mut change = f64::INFINITY;
    for step in 1..=MAX_STEPS {
        let mut next = apply(&basis[step - 1])?;
        let scale = next.norm();
        diagonal.push(next.dot(&basis[step - 1]));
        // Twice is enough (Parlett 1998, section 6.9).
        for _ in 0..2 {
            for vector in &basis {
                next.axpy(-next.dot(vector), vector, 1.0);
            }
        }
        let Some(found) = first_column(&diagonal, &beside) else {
            return Ok(None);
        };
        let before = last.resize_vertically(step, 0.0);
        change = (&found - before).norm() / found.norm();
        let length = next.norm();
        if change <= TOLERANCE || length <= BREAKDOWN * scale {
            let terms = basis.iter().zip(found.iter());
            let zero = DVector::zeros(w.len());
            return Ok(Some(terms.fold(zero, |mut sum, (vector, weight)| {
                sum.axpy(norm * weight, vector, 1.0);
                sum
            })));
        }
        last = found;
        beside.push(length);
        basis.push(next / length);
    }
    Err(HydroError::RootNotConverged {
        steps: MAX_STEPS,
        change,
        target: TOLERANCE,
    })
}

/// `T^(-1/2) e_1` of a tridiagonal matrix; `None` if it is not positive definite.
fn first_column(diagonal: &[f64], beside: &[f64]) -> Option<DVector<f64>> {
    let count = diagonal.len();
    let mut matrix = DMatrix::from_diagonal(&DVector::from_column_slice(diagonal));
    for (k, entry) in beside.iter().enumerate() {
        matrix[(k, k + 1)] = *entry;
        matrix[(k + 1, k)] = *entry;
    }
    let SymmetricEigen {
        eigenvectors,
        eigenvalues,
    } = SymmetricEigen::new(matrix);
    if !eigenvalues.iter().all(|value| *value > 0.0) {
        return None;
    }
    let weights = (0..count).map(|k| eigenvectors[(0, k)] / eigenvalues[k].sqrt());
    Some(&eigenvectors * DVector::from_iterator(count, weights))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A symmetric matrix with eigenvalues from 1 to 100, by a reflection.
    fn matrix(smallest: f64) -> DMatrix<f64> {
        let count = 30;
        let n = DVector::from_fn(count, |k, _| (1.0 + k as f64).sin()).normalize();
        let reflection = DMatrix::identity(count, count) - 2.0 * &n * n.transpose();
        let values = DVector::from_fn(count, |k, _| {
            smallest * (100.0_f64 / smallest.abs()).powf(k as f64 / (count - 1) as f64)
        });
        &reflection * DMatrix::from_diagonal(&values) * &reflection
    }

    #[test]
    fn applied_twice_it_is_the_inverse() {
        let a = matrix(1.0);
        let w = DVector::from_fn(a.nrows(), |k, _| (3.0 * k as f64).cos());
        let half = |w: &DVector<f64>| inverse_root(w, |x| Ok(&a * x)).unwrap().unwrap();
        let found = half(&half(&w));
        let exact = a.clone().cholesky().unwrap().solve(&w);
        // The change of the last step bounds the error to a factor of the rate of convergence.
        assert!((&found - &exact).norm() < 10.0 * TOLERANCE * exact.norm());
        assert_eq!(half(&DVector::zeros(30)), DVector::zeros(30));
    }

    #[test]
    fn an_eigenvector_takes_one_step_and_an_indefinite_operator_has_no_root() {
        let w = DVector::from_element(5, 2.0);
        let found = inverse_root(&w, |x| Ok(4.0 * x)).unwrap().unwrap();
        assert!((found - 0.5 * &w).norm() < 1e-15);
        let bad = matrix(-1.0);
        let w = DVector::from_element(bad.nrows(), 1.0);
        assert!(inverse_root(&w, |x| Ok(&bad * x)).unwrap().is_none());
    }
}
