//! Null spaces of singular operators, and Krylov methods on their complements.

use std::fmt;
use std::ops::Range;

use super::report::{KrylovParams, SolveReport};
use crate::csr::{check_finite, check_shape};
use crate::lanczos::pseudo_random;
use crate::vector::{axpy, dot, norm, scale};
use crate::{LinalgError, LinearOperator, Preconditioner, PreconditionerKind};

/// A vector that keeps less than this part of its length beside the others depends on them.
const DEPENDENT: f64 = 1e-10;

/// `||A v|| / ||A||` up to which `v` counts as a null vector; assembly in f64 leaves about 1e-15.
const NULL: f64 = 1e-8;

/// A right-hand side of which no more than this part is left by the projection is rounding error.
const ROUNDING: f64 = 1e-14;

/// Vectors `v` with `A v = 0`, for [`KrylovParams::with_null_vectors`].
///
/// A system `A x = b` with a singular `A` has a solution only if `b` is orthogonal to the left null
/// vectors, `A^T w = 0`, which are the same for a symmetric `A`. The Krylov methods then solve
/// `A x = P b` with `P b` the orthogonal projection of `b`, return the solution that is orthogonal
/// to the null vectors, and report `||b - P b|| / ||b||` as [`SolveReport::rhs_removed`].
///
/// Examples are a Poisson problem with Neumann conditions on the whole boundary
/// ([`NullVectors::constant`]) and enclosed flow, whose pressure is determined up to a constant
/// ([`NullVectors::constant_on`]).
#[derive(Clone, PartialEq)]
pub struct NullVectors {
    /// Orthonormal.
    right: Vec<Vec<f64>>,
    /// Orthonormal null vectors of `A^T` where they differ.
    left: Option<Vec<Vec<f64>>>,
}

impl NullVectors {
    /// The span of `vectors`, which may have any lengths and angles.
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
    pub fn constant(n: usize) -> Self {
        Self::constant_on(n, 0..n)
    }

    /// The vectors of length `n` that are constant on `range` and zero elsewhere.
    ///
    /// For the constant pressure of enclosed flow `range` is
    /// [`SaddleSystem::pressure_range`](crate::SaddleSystem::pressure_range).
    ///
    /// # Panics
    /// When `range` does not lie in `0..n`.
    pub fn constant_on(n: usize, range: Range<usize>) -> Self {
        let mut vector = vec![0.0; n];
        let value = (range.len() as f64).sqrt().recip();
        vector[range.clone()].fill(value);
        NullVectors {
            right: if range.is_empty() {
                Vec::new()
            } else {
                vec![vector]
            },
            left: None,
        }
    }

    /// The same with other null vectors of the transpose, for operators that are not symmetric.
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
    /// # Panics
    /// When `x` has another length than the null vectors.
    pub fn project_out(&self, x: &mut [f64]) {
        project_out(&self.right, x);
    }

    fn left(&self) -> &[Vec<f64>] {
        self.left.as_ref().unwrap_or(&self.right)
    }

    /// Refuses vectors that do not fit `operator` or that it does not map to zero.
    ///
    /// `||A||` is estimated from below by `||A w|| / ||w||` for a fixed pseudo-random `w`.
    fn check(&self, operator: &dyn LinearOperator) -> Result<(), LinalgError> {
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
            if ratio > NULL {
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
        if !(size > DEPENDENT * before && size.is_finite()) {
            return Err(LinalgError::Dependent { index });
        }
        scale(size.recip(), &mut vector);
        basis.push(vector);
    }
    Ok(basis)
}

/// `x <- x - sum_i (v_i . x) v_i` for orthonormal `v_i`.
fn project_out(basis: &[Vec<f64>], x: &mut [f64]) {
    for vector in basis {
        assert_eq!(vector.len(), x.len(), "length of the null vector");
        axpy(-dot(vector, x), vector, x);
    }
}

/// A preconditioner `N` between projections: `z = P_right N P_left r`.
///
/// Without the projections a preconditioner of a singular matrix returns a large multiple of a null
/// vector, in whose rounding error the rest is lost.
struct Projected<'a> {
    preconditioner: &'a mut dyn Preconditioner,
    null_vectors: &'a NullVectors,
    projected: Vec<Vec<f64>>,
}

impl Preconditioner for Projected<'_> {
    fn size(&self) -> usize {
        self.preconditioner.size()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.apply_columns(&[r], &mut [z]);
    }

    fn apply_columns(&mut self, r: &[&[f64]], z: &mut [&mut [f64]]) {
        if self.projected.len() < r.len() {
            self.projected.resize(r.len(), Vec::new());
        }
        for (r, projected) in r.iter().zip(&mut self.projected) {
            projected.clear();
            projected.extend_from_slice(r);
            project_out(self.null_vectors.left(), projected);
        }
        let columns: Vec<&[f64]> = self.projected.iter().map(Vec::as_slice).collect();
        self.preconditioner.apply_columns(&columns[..r.len()], z);
        for z in z {
            self.null_vectors.project_out(z);
        }
    }

    fn kind(&self) -> PreconditionerKind {
        self.preconditioner.kind()
    }
}

/// Runs `method` on the complement of the null space of `params`, and on all vectors without one.
pub(super) fn solve(
    operator: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    b: &[&[f64]],
    x: &mut [&mut [f64]],
    params: &KrylovParams,
    method: impl FnOnce(
        &mut dyn Preconditioner,
        &[&[f64]],
        &mut [&mut [f64]],
    ) -> Result<Vec<SolveReport>, LinalgError>,
) -> Result<Vec<SolveReport>, LinalgError> {
    let Some(null_vectors) = params.null_vectors.as_deref() else {
        return method(preconditioner, b, x);
    };
    null_vectors.check(operator)?;
    let mut projected = Vec::with_capacity(b.len());
    let mut removed = Vec::with_capacity(b.len());
    for b in b {
        check_shape("right-hand side", (b.len(), 1), (operator.rows(), 1))?;
        check_finite("right-hand side", b)?;
        let before = norm(b);
        let mut rest = b.to_vec();
        project_out(null_vectors.left(), &mut rest);
        if norm(&rest) <= ROUNDING * before {
            rest.fill(0.0);
        }
        let difference: Vec<f64> = b.iter().zip(&rest).map(|(b, rest)| b - rest).collect();
        removed.push(if before > 0.0 {
            norm(&difference) / before
        } else {
            0.0
        });
        projected.push(rest);
    }
    for x in x.iter_mut() {
        check_shape("solution vector", (x.len(), 1), (operator.cols(), 1))?;
        check_finite("initial guess", x)?;
        null_vectors.project_out(x);
    }
    let mut preconditioner = Projected {
        preconditioner,
        null_vectors,
        projected: Vec::new(),
    };
    let b: Vec<&[f64]> = projected.iter().map(Vec::as_slice).collect();
    let mut reports = method(&mut preconditioner, &b, x)?;
    for (report, removed) in reports.iter_mut().zip(removed) {
        report.rhs_removed = removed;
    }
    // vectors kept in f32 bring back a component of the order of rounding
    for x in x {
        null_vectors.project_out(x);
    }
    Ok(reports)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn null_vectors_are_made_orthonormal() {
        let space = NullVectors::new(vec![vec![2.0, 0.0, 0.0], vec![3.0, 4.0, 0.0]]);
        let mut x = [5.0, 6.0, 7.0];
        space.expect("independent").project_out(&mut x);
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
