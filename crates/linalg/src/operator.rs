//! Interfaces of the Krylov methods to matrices and preconditioners.

use crate::columns::assert_lengths;

/// Replaces numbers of this process by their sums over all processes, the same on each of them.
pub type SumOverProcesses<'a> = dyn Fn(&mut [f64]) + Sync + 'a;

/// A linear map `y <- A x` on flat vectors.
pub trait LinearOperator: Sync {
    /// Length of `y`.
    fn rows(&self) -> usize;

    /// Length of `x`.
    fn cols(&self) -> usize;

    /// Overwrites `y` with `A x`; allocates nothing.
    ///
    /// # Panics
    /// If the length of `x` is not `cols` or that of `y` not `rows`; the solvers check this first.
    fn apply(&self, x: &[f64], y: &mut [f64]);

    /// Overwrites each column of `y` with `A` times the same column of `x`.
    ///
    /// Takes one pass over the matrix if the operator supports it. Each column of the result is
    /// bitwise that of [`apply`](LinearOperator::apply).
    ///
    /// # Panics
    /// As [`apply`](LinearOperator::apply), and if the numbers of columns differ.
    fn apply_columns(&self, x: &[&[f64]], y: &mut [&mut [f64]]) {
        assert_eq!(x.len(), y.len(), "numbers of columns");
        for (x, y) in x.iter().zip(y) {
            self.apply(x, y);
        }
    }

    /// Weights `w_i > 0` of a residual norm that reflects errors of the solution.
    ///
    /// The norm is `(sum w_i r_i^2)^(1/2)`. With the reciprocal diagonal of a symmetric operator as
    /// weights it depends neither on units nor on the sizes of elements. `None` if the operator has
    /// no such weights.
    fn residual_weights(&self) -> Option<&[f32]> {
        None
    }

    /// The sum over processes, if the vectors are divided between several; `None` if they are not.
    ///
    /// Each process then has its own entries of every vector, and may have further ones that are
    /// zero. [`fgmres`](crate::fgmres) runs on all processes at the same time, with the same
    /// numbers of iterations: it calls this function for norms and products of vectors. The other
    /// methods refuse such an operator.
    fn sum_over_processes(&self) -> Option<&SumOverProcesses<'_>> {
        None
    }

    /// Whether `A = A^T` is known.
    ///
    /// [`cg`](crate::cg) and [`minres`](crate::minres) refuse other operators.
    fn is_symmetric(&self) -> bool {
        false
    }
}

/// An approximate inverse `z <- N r`. It owns its workspace, hence `&mut self`.
pub trait Preconditioner {
    /// Length of `r` and of `z`.
    fn size(&self) -> usize;

    /// Overwrites `z` with the approximate solution of `A z = r`; allocates nothing.
    ///
    /// # Panics
    /// If the length of `r` or `z` is not `size`; the solvers check this first.
    fn apply(&mut self, r: &[f64], z: &mut [f64]);

    /// Overwrites each column of `z` with the approximate solution for the same column of `r`.
    ///
    /// Takes one pass over the matrices if the preconditioner supports it. Each column of the
    /// result is bitwise that of [`apply`](Preconditioner::apply). Buffers grow with the number of
    /// columns.
    ///
    /// # Panics
    /// As [`apply`](Preconditioner::apply), and if the numbers of columns differ.
    fn apply_columns(&mut self, r: &[&[f64]], z: &mut [&mut [f64]]) {
        assert_eq!(r.len(), z.len(), "numbers of columns");
        for (r, z) in r.iter().zip(z) {
            self.apply(r, z);
        }
    }

    /// Properties of the map `r -> z`.
    fn kind(&self) -> PreconditionerKind;
}

/// Properties of a preconditioner; each kind is more general than those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum PreconditionerKind {
    /// Linear, symmetric and positive definite (to its own precision): suits all methods.
    PositiveDefinite,
    /// A fixed linear map: suits every GMRES method.
    Linear,
    /// Changes from call to call: suits flexible methods only.
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
        assert_lengths(&[r], self.0, &[&mut *z], self.0);
        z.copy_from_slice(r);
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::PositiveDefinite
    }
}
