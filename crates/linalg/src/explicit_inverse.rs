//! Preconditioners given as operators.

use crate::csr::check_shape;
use crate::{LinalgError, LinearOperator, Preconditioner, PreconditionerKind};

/// An operator that is an approximate inverse itself: `z = N r`.
///
/// For example a diagonal matrix of reciprocals, or a sparse approximate inverse, as a block of a
/// [`BlockPreconditioner`](crate::BlockPreconditioner).
///
/// ```
/// use linalg::{Csr, CsrOperator, ExplicitInverse, Preconditioner, PreconditionerKind};
/// let halves: Csr = Csr::eye(3).map(|one: &f64| 0.5 * one);
/// let kind = PreconditionerKind::PositiveDefinite;
/// let mut inverse = ExplicitInverse::new(CsrOperator::new(halves)?, kind)?;
/// let mut z = [0.0; 3];
/// inverse.apply(&[2.0, 4.0, 6.0], &mut z);
/// assert_eq!(z, [1.0, 2.0, 3.0]);
/// # Ok::<(), linalg::LinalgError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ExplicitInverse<A> {
    operator: A,
    kind: PreconditionerKind,
}

impl<A: LinearOperator> ExplicitInverse<A> {
    /// Uses `operator`, of which the caller knows that it is of the given `kind`.
    ///
    /// # Errors
    /// [`LinalgError::Shape`] unless the operator is square; [`LinalgError::NotSymmetric`] for
    /// [`PreconditionerKind::PositiveDefinite`] if it is not symmetric.
    pub fn new(operator: A, kind: PreconditionerKind) -> Result<Self, LinalgError> {
        let (found, expected) = (
            (operator.rows(), operator.cols()),
            (operator.rows(), operator.rows()),
        );
        check_shape("explicit inverse", found, expected)?;
        if kind == PreconditionerKind::PositiveDefinite && !operator.is_symmetric() {
            let method = "a positive definite preconditioner";
            return Err(LinalgError::NotSymmetric { method });
        }
        Ok(ExplicitInverse { operator, kind })
    }
}

impl<A: LinearOperator> Preconditioner for ExplicitInverse<A> {
    fn size(&self) -> usize {
        self.operator.rows()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.operator.apply(r, z);
    }

    fn apply_columns(&mut self, r: &[&[f64]], z: &mut [&mut [f64]]) {
        self.operator.apply_columns(r, z);
    }

    fn kind(&self) -> PreconditionerKind {
        self.kind
    }
}
