//! What a Krylov method needs to know of a matrix and of a preconditioner.

/// A linear map `y <- A x` between flat vectors.
pub trait LinearOperator: Sync {
    /// Length of `y`.
    fn rows(&self) -> usize;

    /// Length of `x`.
    fn cols(&self) -> usize;

    /// Overwrites `y` with `A x`; allocates nothing.
    ///
    /// # Panics
    /// When `x` or `y` has another length than `cols` or `rows`; the solvers check before.
    fn apply(&self, x: &[f64], y: &mut [f64]);

    /// Overwrites each of the columns `y` with `A` times that of `x`, in one pass over the matrix where the operator knows how.
    ///
    /// Each column comes out as [`apply`](LinearOperator::apply) would make it, to the last bit.
    ///
    /// # Panics
    /// As [`apply`](LinearOperator::apply).
    fn apply_columns(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        for (x, y) in x.iter().zip(y) {
            self.apply(x, y);
        }
    }

    /// Weights `w_i > 0` of a norm `(sum w_i r_i^2)^(1/2)` that weighs residuals by what they do to the solution, if the operator knows one.
    ///
    /// With the reciprocal diagonal of a symmetric operator it does not depend on units, nor on the size of the elements a row belongs to.
    fn residual_weights(&self) -> Option<&[f32]> {
        None
    }

    /// Whether `A = A^T` is known to hold: [`cg`](crate::cg) and [`minres`](crate::minres) refuse other operators.
    fn is_symmetric(&self) -> bool {
        false
    }
}

/// An approximate inverse `z <- N r`; it owns its work space, hence `&mut self`.
pub trait Preconditioner {
    /// Length of `r` and of `z`.
    fn size(&self) -> usize;

    /// Overwrites `z` with the approximate solution of `A z = r`; allocates nothing.
    ///
    /// # Panics
    /// When `r` or `z` has another length than `size`; the solvers check before.
    fn apply(&mut self, r: &[f64], z: &mut [f64]);

    /// Overwrites each of the columns `z` with the approximate solution for that of `r`, in one pass over the matrices where the
    /// preconditioner knows how.
    ///
    /// Each column comes out as [`apply`](Preconditioner::apply) would make it, to the last bit. Buffers may grow when there are more columns than before.
    ///
    /// # Panics
    /// As [`apply`](Preconditioner::apply).
    fn apply_columns(&mut self, r: &[&[f64]], z: &mut [&mut [f64]]) {
        for (r, z) in r.iter().zip(z) {
            self.apply(r, z);
        }
    }

    /// What solvers may assume of the map `r -> z`.
    fn kind(&self) -> PreconditionerKind;
}

/// What a solver may assume of a preconditioner; each kind includes those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PreconditionerKind {
    /// Linear, symmetric and positive definite (to its own precision): any method.
    PositiveDefinite,
    /// A fixed linear map: any GMRES.
    Linear,
    /// Changes from call to call: flexible methods only.
    Variable,
}

/// No preconditioning: `z = r`.
#[derive(Debug, Clone, Copy)]
pub struct Identity(
    /// Length of the vectors.
    pub usize,
);

impl Preconditioner for Identity {
    fn size(&self) -> usize {
        self.0
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        z.copy_from_slice(r);
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::PositiveDefinite
    }
}
