//! Null spaces of singular operators.

use std::fmt;
use std::ops::Range;

use crate::csr::{check_finite, check_shape};
use crate::lanczos::pseudo_random;
use crate::vector::{axpy, dot, norm, scale};
use crate::{LinalgError, LinearOperator};

/// Fraction of its length below which an orthogonalised vector depends linearly on the others.
const DEPENDENCE_TOLERANCE: f64 = 1e-10;

/// `||A v|| / ||A||` up to which `v` counts as a null vector; assembly in f64 leaves about 1e-15.
const NULL_TOLERANCE: f64 = 1e-8;

/// Null vectors of a singular operator: vectors `v` with `A v = 0`.
///
/// For [`KrylovParams::with_null_vectors`](crate::KrylovParams::with_null_vectors).
///
/// A system `A x = b` with a singular `A` has a solution only if `b` is orthogonal to the left null
/// vectors `w`, `A^T w = 0`. For a symmetric `A` left and right null vectors are the same. The
/// Krylov methods then solve `A x = P b` with `P b` the orthogonal projection of `b`, return the
/// solution that is orthogonal to the null vectors, and report `||b - P b|| / ||b||` as
/// [`SolveReport::rhs_removed`](crate::SolveReport::rhs_removed).
///
/// Examples are a Poisson problem with Neumann conditions on the whole boundary
/// ([`NullVectors::constant`]) and enclosed flow, whose pressure is determined up to a constant
/// ([`NullVectors::constant_on`]).
#[derive(Clone, PartialEq)]
pub struct NullVectors {
    /// Orthonormal null vectors of `A`.
    right: Vec<Vec<f64>>,
    /// Orthonormal null vectors of `A^T`; `None` if they equal `right`.
    left: Option<Vec<Vec<f64>>>,
}

impl NullVectors {
    /// The span of `vectors`, which need not be orthonormal.
    ///
    /// # Errors
    /// [`LinalgError::Shape`] for vectors of different sizes, [`LinalgError::NotFinite`],
    /// [`LinalgError::Dependent`] for linearly dependent ones.
    pub fn new(vectors: Vec<Vec<f64>>) -> Result<Self, LinalgError> {
        Ok(NullVectors {
            right: orthonormal(vectors)?,
            left: None,
        })
    }

    /// The constant vectors of length `n`.
    ///
    /// # Errors
    /// Those of [`NullVectors::constant_on`].
    pub fn constant(n: usize) -> Result<Self, LinalgError> {
        Self::constant_on(n, 0..n)
    }

    /// The vectors of length `n` that are constant on `range` and zero elsewhere.
    ///
    /// For the constant pressure of enclosed flow `range` is
    /// [`SaddleSystem::pressure_range`](crate::SaddleSystem::pressure_range).
    ///
    /// # Errors
    /// [`LinalgError::Shape`] if `range` does not lie in `0..n`, [`LinalgError::Parameter`] if the
    /// memory does not suffice for `n` numbers.
    pub fn constant_on(n: usize, range: Range<usize>) -> Result<Self, LinalgError> {
        if range.start > range.end || range.end > n {
            return Err(LinalgError::Shape {
                what: "range of a constant null vector",
                expected: (0, n),
                found: (range.start, range.end),
            });
        }
        let mut right = Vec::new();
        if !range.is_empty() {
            let mut vector = Vec::new();
            (vector.try_reserve_exact(n)).map_err(|_| LinalgError::Parameter {
                name: "length of a null vector",
                value: n as f64,
                range: "small enough for the memory",
            })?;
            vector.resize(n, 0.0);
            vector[range.clone()].fill((range.len() as f64).sqrt().recip());
            right.push(vector);
        }
        Ok(NullVectors { right, left: None })
    }

    /// The same null space, with the given null vectors of `A^T` for an unsymmetric `A`.
    ///
    /// # Errors
    /// Those of [`NullVectors::new`].
    pub fn with_left(mut self, vectors: Vec<Vec<f64>>) -> Result<Self, LinalgError> {
        self.left = Some(orthonormal(vectors)?);
        Ok(self)
    }

    /// Number of linearly independent null vectors.
    pub fn dimension(&self) -> usize {
        self.right.len()
    }

    /// Subtracts from `x` its components along the null vectors.
    ///
    /// # Errors
    /// [`LinalgError::Shape`] when `x` has another length than the null vectors.
    pub fn project_out(&self, x: &mut [f64]) -> Result<(), LinalgError> {
        if let Some(vector) = self.right.first() {
            check_shape("vector to be projected", (x.len(), 1), (vector.len(), 1))?;
        }
        project_out(&self.right, x);
        Ok(())
    }

    pub(super) fn right(&self) -> &[Vec<f64>] {
        &self.right
    }

    pub(super) fn left(&self) -> &[Vec<f64>] {
        self.left.as_ref().unwrap_or(&self.right)
    }

    /// Checks that `operator` has the size of the vectors and maps each of them to zero.
    ///
    /// `||A||` is estimated from below by `||A w|| / ||w||` for a fixed pseudo-random `w`.
    pub(super) fn check(&self, operator: &dyn LinearOperator) -> Result<(), LinalgError> {
        let (rows, cols) = (operator.rows(), operator.cols());
        for (vectors, size) in [(&self.right[..], cols), (self.left(), rows)] {
            for vector in vectors {
                check_shape("null vector", (vector.len(), 1), (size, 1))?;
            }
        }
        let noise: Vec<f64> = (0..cols as u64).map(pseudo_random).collect();
        let mut product = vec![0.0; rows];
        operator.apply(&noise, &mut product);
        let operator_norm = norm(&product) / norm(&noise);
        for (index, vector) in self.right.iter().enumerate() {
            operator.apply(vector, &mut product);
            let ratio = norm(&product) / operator_norm;
            // a zero operator maps everything to zero, NaN is reported by the method itself
            if ratio > NULL_TOLERANCE {
                return Err(LinalgError::NotNullVector { index, ratio });
            }
        }
        Ok(())
    }
}

impl fmt::Debug for NullVectors {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NullVectors")
            .field("dimension", &self.dimension())
            .field("differs_on_the_left", &self.left.is_some())
            .finish()
    }
}

/// An orthonormal basis of the span (modified Gram-Schmidt, twice).
fn orthonormal(vectors: Vec<Vec<f64>>) -> Result<Vec<Vec<f64>>, LinalgError> {
    let mut basis: Vec<Vec<f64>> = Vec::with_capacity(vectors.len());
    for (index, mut vector) in vectors.into_iter().enumerate() {
        if let Some(first) = basis.first() {
            check_shape("null vector", (vector.len(), 1), (first.len(), 1))?;
        }
        check_finite("null vector", &vector)?;
        let before = norm(&vector);
        for _ in 0..2 {
            project_out(&basis, &mut vector);
        }
        let size = norm(&vector);
        if !(size > DEPENDENCE_TOLERANCE * before && size.is_finite()) {
            return Err(LinalgError::Dependent { index });
        }
        scale(size.recip(), &mut vector);
        basis.push(vector);
    }
    Ok(basis)
}

/// `x <- x - sum_i (v_i . x) v_i` for orthonormal `v_i`.
pub(super) fn project_out(basis: &[Vec<f64>], x: &mut [f64]) {
    for vector in basis {
        assert_eq!(vector.len(), x.len(), "length of the null vector");
        axpy(-dot(vector, x), vector, x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn null_vectors_are_made_orthonormal() {
        let space = NullVectors::new(vec![vec![2.0, 0.0, 0.0], vec![3.0, 4.0, 0.0]]);
        let mut x = [5.0, 6.0, 7.0];
        project_out(space.expect("independent").right(), &mut x);
        assert_eq!(x, [0.0, 0.0, 7.0]);
    }

    #[test]
    fn dependent_and_misshapen_vectors_are_refused() {
        let dependent = NullVectors::new(vec![vec![1.0, 1.0], vec![2.0, 2.0]]);
        assert_eq!(dependent, Err(LinalgError::Dependent { index: 1 }));
        let zero = NullVectors::new(vec![vec![0.0, 0.0]]);
        assert_eq!(zero, Err(LinalgError::Dependent { index: 0 }));
        let misshapen = NullVectors::new(vec![vec![1.0, 1.0], vec![2.0]]);
        assert!(matches!(misshapen, Err(LinalgError::Shape { .. })));
    }
}
