//! Sparse symmetric factorisations by faer on a nested-dissection ordering.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::{ldlt::factor::LdltRegularization, llt::factor::LltRegularization};
use faer::perm::PermRef;
use faer::sparse::linalg::cholesky::{
    LdltRef, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};

use crate::csr::Rows;
use crate::{Csr, LinalgError};

/// Parts faer's dense kernels are cut into. The cut decides the rounding, so it is fixed, whatever the number of threads:
/// `Par::rayon(0)` (one part a thread) gave other digits on one thread than on two.
const PARALLEL_DEGREE: usize = 4;

/// Which factorisation a matrix admits without pivoting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Definiteness {
    /// `L L^T`: symmetric positive definite.
    Positive,
    /// `L D L^T`: quasi-definite, `[A B^T; B -C]` with `A` and `C` positive definite (Vanderbei 1995).
    Quasi,
}

/// The factors of a symmetric sparse matrix.
pub(crate) struct SparseFactor {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
    definiteness: Definiteness,
    parallel: Par,
    scratch: MemBuffer,
    /// Right-hand sides `scratch` is large enough for.
    columns: usize,
}

impl SparseFactor {
    /// Factorises `matrix`, symmetric with both triangles stored, in the elimination order `order[k]` = k-th pivot.
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] for a zero, negative or NaN pivot or lack of memory.
    pub fn new(
        what: &'static str,
        matrix: &Csr,
        order: &[usize],
        definiteness: Definiteness,
        columns: usize,
    ) -> Result<Self, LinalgError> {
        let failed = |detail: String| LinalgError::Factorisation { what, detail };
        let n = matrix.rows();
        let mut inverse = vec![0; n];
        for (k, &i) in order.iter().enumerate() {
            inverse[i] = k;
        }
        let permutation = PermRef::new_checked(order, &inverse, n);
        let row_pointers = Rows::of(matrix).indptr;
        let indices: Vec<usize> = matrix.indices().iter().map(|&j| j as usize).collect();
        // rows of a symmetric matrix are its columns
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, row_pointers, None, &indices);
        let symbolic = factorize_symbolic_cholesky(
            pattern,
            Side::Lower,
            SymmetricOrdering::Custom(permutation),
            Default::default(),
        )
        .map_err(|e| failed(e.to_string()))?;
        let parallel = Par::rayon(PARALLEL_DEGREE);
        let mut values = vec![0.0; symbolic.len_val()];
        let sparse = SparseColMatRef::new(pattern, matrix.data());
        match definiteness {
            Definiteness::Positive => {
                let need = symbolic.factorize_numeric_llt_scratch::<f64>(parallel, Spec::default());
                let mut memory =
                    MemBuffer::try_new(need).map_err(|_| failed("out of memory".into()))?;
                symbolic
                    .factorize_numeric_llt(
                        &mut values,
                        sparse,
                        Side::Lower,
                        LltRegularization::default(),
                        parallel,
                        MemStack::new(&mut memory),
                        Spec::default(),
                    )
                    .map_err(|e| failed(format!("{e:?}")))?;
            }
            Definiteness::Quasi => {
                let need =
                    symbolic.factorize_numeric_ldlt_scratch::<f64>(parallel, Spec::default());
                let mut memory =
                    MemBuffer::try_new(need).map_err(|_| failed("out of memory".into()))?;
                symbolic
                    .factorize_numeric_ldlt(
                        &mut values,
                        sparse,
                        Side::Lower,
                        LdltRegularization::default(),
                        parallel,
                        MemStack::new(&mut memory),
                        Spec::default(),
                    )
                    .map_err(|e| failed(format!("{e:?}")))?;
            }
        }
        // faer reports an exactly zero pivot only; a tiny one ends in NaN or infinity
        if values.iter().any(|v| !v.is_finite()) {
            return Err(failed(
                "a pivot vanished, the factors are not finite".into(),
            ));
        }
        let need = symbolic.solve_in_place_scratch::<f64>(columns, parallel);
        let scratch = MemBuffer::try_new(need).map_err(|_| failed("out of memory".into()))?;
        Ok(SparseFactor {
            symbolic,
            values,
            definiteness,
            parallel,
            scratch,
            columns,
        })
    }

    /// Stored entries of the factor.
    pub fn entries(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Overwrites the columns of `rhs` (n each, one after another) with the solutions, in groups of `columns`.
    pub fn solve_in_place(&mut self, rhs: &mut [f64]) {
        let n = self.symbolic.nrows();
        if n == 0 {
            return;
        }
        for group in rhs.chunks_mut(n * self.columns) {
            let group = MatMut::from_column_major_slice_mut(group, n, group.len() / n);
            let stack = MemStack::new(&mut self.scratch);
            match self.definiteness {
                Definiteness::Positive => LltRef::new(&self.symbolic, &self.values)
                    .solve_in_place_with_conj(Conj::No, group, self.parallel, stack),
                Definiteness::Quasi => LdltRef::new(&self.symbolic, &self.values)
                    .solve_in_place_with_conj(Conj::No, group, self.parallel, stack),
            }
        }
    }
}
