//! Sparse symmetric factorisations by faer in a given elimination order.

use std::num::NonZeroUsize;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::{ldlt::factor::LdltRegularization, llt::factor::LltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    LdltRef, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::traits::RealField;
use faer::{Conj, MatMut, Par, Side, Spec};

use crate::csr::Rows;
use crate::vector::{max_abs, power_of_two_below};
use crate::{Csr, LinalgError};

/// Number of parts into which faer's dense kernels divide their work.
///
/// The division determines the rounding, so it is fixed for any number of threads: with
/// `Par::rayon(0)` (one part per thread) the digits on one thread differed from those on two.
const PARALLEL_DEGREE: Par = Par::Rayon(NonZeroUsize::new(4).unwrap());

/// The factorisation that a matrix admits without pivoting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Definiteness {
    /// `L L^T`: symmetric positive definite.
    Positive,
    /// `L D L^T`: quasi-definite, `[A B^T; B -C]` with `A` and `C` positive definite (Vanderbei
    /// 1995).
    Quasi,
}

/// Precision in which factors are computed and stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Precision {
    /// 8 bytes per nonzero.
    Double,
    /// 4 bytes per nonzero and about half the time; the factors are then a preconditioner.
    Single,
}

enum Values {
    Double(Vec<f64>),
    Single(Vec<f32>),
}

/// The factors of a symmetric sparse matrix.
pub(crate) struct SparseFactor {
    symbolic: SymbolicCholesky<usize>,
    values: Values,
    definiteness: Definiteness,
    scratch: MemBuffer,
    rounded: Vec<f32>,
    /// Number of right-hand sides for which `scratch` is large enough.
    columns: usize,
}

impl SparseFactor {
    /// Factorises a symmetric `matrix` with both triangles stored.
    ///
    /// `order[k]` is the k-th pivot; `columns` right-hand sides are solved together.
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] for a zero, negative or NaN pivot, or lack of memory.
    pub fn new(
        what: &'static str,
        matrix: &Csr,
        order: &[usize],
        definiteness: Definiteness,
        precision: Precision,
        columns: usize,
    ) -> Result<Self, LinalgError> {
        let failed = |detail: String| LinalgError::Factorisation { what, detail };
        let n = matrix.rows();
        let mut inverse = vec![0; n];
        for (k, &i) in order.iter().enumerate() {
            inverse[i] = k;
        }
        let permutation = PermRef::new_checked(order, &inverse, n);
        let row_pointers = Rows::new(matrix).indptr;
        let indices: Vec<usize> = matrix.indices().iter().map(|&j| j as usize).collect();
        // the rows of a symmetric matrix are its columns
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, row_pointers, None, &indices);
        let symbolic = factorize_symbolic_cholesky(
            pattern,
            Side::Lower,
            SymmetricOrdering::Custom(permutation),
            Default::default(),
        )
        .map_err(|e| failed(e.to_string()))?;
        let (values, need) = match precision {
            Precision::Double => {
                let sparse = SparseColMatRef::new(pattern, matrix.data());
                let values = in_pool(|| factorise(&symbolic, sparse, definiteness));
                let values = values.map_err(failed)?;
                let need = symbolic.solve_in_place_scratch::<f64>(columns, PARALLEL_DEGREE);
                (Values::Double(values), need)
            }
            Precision::Single => {
                let entries: Vec<f32> = matrix.data().iter().map(|&v| v as f32).collect();
                let sparse = SparseColMatRef::new(pattern, &entries);
                let values = in_pool(|| factorise(&symbolic, sparse, definiteness));
                let values = values.map_err(failed)?;
                let need = symbolic.solve_in_place_scratch::<f32>(columns, PARALLEL_DEGREE);
                (Values::Single(values), need)
            }
        };
        let scratch = MemBuffer::try_new(need).map_err(|_| failed("out of memory".into()))?;
        Ok(SparseFactor {
            symbolic,
            values,
            definiteness,
            scratch,
            rounded: Vec::new(),
            columns,
        })
    }

    /// Number of nonzeros of the factor.
    pub fn nnz(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Bytes of the factor.
    pub fn bytes(&self) -> usize {
        match &self.values {
            Values::Double(values) => size_of_val(values.as_slice()),
            Values::Single(values) => size_of_val(values.as_slice()),
        }
    }

    /// Overwrites the columns of `rhs` (n entries each, one after another) with the solutions.
    pub fn solve_in_place(&mut self, rhs: &mut [f64]) {
        let n = self.symbolic.nrows();
        if n == 0 {
            return;
        }
        let (symbolic, definiteness) = (&self.symbolic, self.definiteness);
        in_pool(|| {
            for group in rhs.chunks_mut(n * self.columns) {
                let stack = MemStack::new(&mut self.scratch);
                match &self.values {
                    Values::Double(values) => solve(symbolic, values, definiteness, group, stack),
                    Values::Single(values) => {
                        // scaled to fit f32, by a power of two that causes no rounding error
                        let scale = power_of_two_below(max_abs(group));
                        self.rounded.clear();
                        self.rounded
                            .extend(group.iter().map(|v| (v / scale) as f32));
                        solve(symbolic, values, definiteness, &mut self.rounded, stack);
                        for (v, r) in group.iter_mut().zip(&self.rounded) {
                            *v = f64::from(*r) * scale;
                        }
                    }
                }
            }
        });
    }
}

/// Runs `work` on a thread of the pool.
///
/// faer forks once per supernode. From outside the pool each fork would be handed over and awaited:
/// a million times, a quarter of the run time with 283 000 dofs.
fn in_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::scope(|_| work())
}

/// The numeric phase.
fn factorise<T: RealField>(
    symbolic: &SymbolicCholesky<usize>,
    matrix: SparseColMatRef<'_, usize, T>,
    definiteness: Definiteness,
) -> Result<Vec<T>, String> {
    let mut values = vec![T::zero_impl(); symbolic.len_val()];
    let memory = |need| MemBuffer::try_new(need).map_err(|_| "out of memory".to_string());
    match definiteness {
        Definiteness::Positive => {
            let need =
                symbolic.factorize_numeric_llt_scratch::<T>(PARALLEL_DEGREE, Spec::default());
            symbolic
                .factorize_numeric_llt(
                    &mut values,
                    matrix,
                    Side::Lower,
                    LltRegularization::default(),
                    PARALLEL_DEGREE,
                    MemStack::new(&mut memory(need)?),
                    Spec::default(),
                )
                .map_err(|e| format!("{e:?}"))?;
        }
        Definiteness::Quasi => {
            let need =
                symbolic.factorize_numeric_ldlt_scratch::<T>(PARALLEL_DEGREE, Spec::default());
            symbolic
                .factorize_numeric_ldlt(
                    &mut values,
                    matrix,
                    Side::Lower,
                    LdltRegularization::default(),
                    PARALLEL_DEGREE,
                    MemStack::new(&mut memory(need)?),
                    Spec::default(),
                )
                .map_err(|e| format!("{e:?}"))?;
        }
    }
    // faer only reports a pivot of exactly zero; a tiny one leads to NaN or infinity
    if values.iter().any(|v| !T::is_finite_impl(v)) {
        return Err("a pivot vanished, the factors are not finite".into());
    }
    Ok(values)
}

fn solve<T: RealField>(
    symbolic: &SymbolicCholesky<usize>,
    values: &[T],
    definiteness: Definiteness,
    rhs: &mut [T],
    stack: &mut MemStack,
) {
    let n = symbolic.nrows();
    let columns = rhs.len() / n;
    let rhs = MatMut::from_column_major_slice_mut(rhs, n, columns);
    match definiteness {
        Definiteness::Positive => LltRef::new(symbolic, values).solve_in_place_with_conj(
            Conj::No,
            rhs,
            PARALLEL_DEGREE,
            stack,
        ),
        Definiteness::Quasi => LdltRef::new(symbolic, values).solve_in_place_with_conj(
            Conj::No,
            rhs,
            PARALLEL_DEGREE,
            stack,
        ),
    }
}
