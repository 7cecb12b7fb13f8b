//! Sparse matrices that are distributed by rows.

use std::ops::Range;
use std::ptr;

use super::session::world;
use super::{Handle, NONE, Session, Vector, int};
use crate::PetscError;
use crate::ffi::{self, DETERMINE, DIFFERENT_NONZERO_PATTERN, Int, MAT_INITIAL_MATRIX, Object};

/// Expected ratio of the nonzeros of a product to those of its factors, PETSc's default.
const FILL: f64 = 2.0;

/// The rows of one process: columns are numbers of the whole matrix.
pub struct Rows {
    starts: Vec<Int>,
    columns: Vec<Int>,
    values: Vec<f64>,
    row: Vec<(Int, f64)>,
}

impl Default for Rows {
    fn default() -> Self {
        Self {
            starts: vec![0],
            columns: Vec::new(),
            values: Vec::new(),
            row: Vec::new(),
        }
    }
}

impl Rows {
    /// Adds an entry to the current row; columns may come in any order, each once.
    pub fn push(&mut self, column: Int, value: f64) {
        self.row.push((column, value));
    }

    /// Ends the current row and begins the next.
    ///
    /// # Errors
    /// [`PetscError::TooLarge`].
    pub fn end_row(&mut self) -> Result<(), PetscError> {
        // PETSc counts nonzeros of sorted rows only.
        self.row.sort_unstable_by_key(|(column, _)| *column);
        for (column, value) in self.row.drain(..) {
            self.columns.push(column);
            self.values.push(value);
        }
        self.starts
            .push(int("nonzeros of one process", self.columns.len())?);
        Ok(())
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }
}

/// A matrix of which each process has consecutive rows.
pub struct Matrix<'s>(pub(super) Handle<'s>);

impl<'s> Matrix<'s> {
    /// A matrix with these rows on this process, which has `columns` entries of a vector.
    ///
    /// Memory is reserved exactly.
    pub fn from_rows(_: &'s Session, rows: &Rows, columns: usize) -> Result<Self, PetscError> {
        let mut object = NONE;
        let (m, n) = (int("rows", rows.len())?, int("columns", columns)?);
        // SAFETY: `starts` has m + 1 ascending entries, the last of which is the length of
        // `columns` and `values`; PETSc copies all three, and checks the columns.
        unsafe {
            call!(MatCreateMPIAIJWithArrays(
                world(),
                m,
                n,
                DETERMINE,
                DETERMINE,
                rows.starts.as_ptr(),
                rows.columns.as_ptr(),
                rows.values.as_ptr(),
                &mut object
            ))?;
            Ok(Self(Handle::owned(object, ffi::MatDestroy)))
        }
    }

    /// The matrix `[a b; c d]`, which shares its blocks.
    ///
    /// # Errors
    /// Those of PETSc, as for blocks whose sizes do not fit.
    pub fn nested(blocks: [[&Matrix<'s>; 2]; 2]) -> Result<Self, PetscError> {
        let blocks = blocks.as_flattened().iter();
        let blocks: Vec<Object> = blocks.map(|block| block.0.object).collect();
        let mut object = NONE;
        // SAFETY: four live matrices in the order of rows; PETSc adds references to them. Null
        // index sets mean consecutive ones.
        unsafe {
            call!(MatCreateNest(
                world(),
                2,
                ptr::null(),
                2,
                ptr::null(),
                blocks.as_ptr(),
                &mut object
            ))?;
            Ok(Self(Handle::owned(object, ffi::MatDestroy)))
        }
    }

    /// The index sets of the two rows of blocks of a nested matrix.
    pub(super) fn index_sets(&self) -> Result<[Object; 2], PetscError> {
        let mut sets = [NONE; 2];
        // SAFETY: only [`Matrix::nested`] makes nested matrices, of two rows; for others PETSc
        // returns an error. The index sets are lent and live as long as the matrix.
        unsafe {
            call!(MatNestGetISs(
                self.0.object,
                sets.as_mut_ptr(),
                ptr::null_mut()
            ))
        }?;
        Ok(sets)
    }

    /// A copy of a nested matrix as one sparse matrix.
    pub fn to_sparse(&self) -> Result<Self, PetscError> {
        // SAFETY: the matrix is live and the name ends with a zero byte.
        unsafe {
            self.make(|out| {
                call!(MatConvert(
                    self.0.object,
                    c"aij".as_ptr(),
                    MAT_INITIAL_MATRIX,
                    out
                ))
            })
        }
    }

    /// The transpose.
    pub fn transpose(&self) -> Result<Self, PetscError> {
        // SAFETY: the matrix is live.
        unsafe { self.make(|out| call!(MatTranspose(self.0.object, MAT_INITIAL_MATRIX, out))) }
    }

    /// The transpose as an operator on this matrix, without a copy of its entries.
    pub fn transposed_view(&self) -> Result<Self, PetscError> {
        // SAFETY: the matrix is live; PETSc adds a reference to it.
        unsafe { self.make(|out| call!(MatCreateTranspose(self.0.object, out))) }
    }

    /// The product `self other`.
    ///
    /// # Errors
    /// Those of PETSc, as for sizes that do not fit.
    pub fn multiply(&self, other: &Matrix<'s>) -> Result<Self, PetscError> {
        // SAFETY: both matrices are live.
        unsafe {
            self.make(|out| {
                call!(MatMatMult(
                    self.0.object,
                    other.0.object,
                    MAT_INITIAL_MATRIX,
                    FILL,
                    out
                ))
            })
        }
    }

    /// The Galerkin product `p^T self p`.
    ///
    /// # Errors
    /// Those of PETSc, as for sizes that do not fit.
    pub fn galerkin(&self, p: &Matrix<'s>) -> Result<Self, PetscError> {
        // SAFETY: both matrices are live.
        unsafe {
            self.make(|out| {
                call!(MatPtAP(
                    self.0.object,
                    p.0.object,
                    MAT_INITIAL_MATRIX,
                    FILL,
                    out
                ))
            })
        }
    }

    /// The matrix that `call` creates.
    ///
    /// # Safety
    /// `call` stores a new matrix, whose reference is the caller's.
    unsafe fn make(
        &self,
        call: impl FnOnce(*mut Object) -> Result<(), PetscError>,
    ) -> Result<Self, PetscError> {
        let mut object = NONE;
        call(&mut object)?;
        // SAFETY: the caller's promise.
        Ok(Self(unsafe { Handle::owned(object, ffi::MatDestroy) }))
    }

    /// `y <- self x`.
    ///
    /// # Errors
    /// Those of PETSc, as for sizes that do not fit.
    pub fn apply(&self, x: &Vector<'s>, y: &mut Vector<'s>) -> Result<(), PetscError> {
        // SAFETY: the matrix and both vectors are live, and the vectors distinct.
        unsafe { call!(MatMult(self.0.object, x.0.object, y.0.object)) }
    }

    /// `self <- diag(left) self diag(right)`.
    ///
    /// # Errors
    /// Those of PETSc, as for sizes that do not fit.
    pub fn scale(
        &mut self,
        left: Option<&Vector<'s>>,
        right: Option<&Vector<'s>>,
    ) -> Result<(), PetscError> {
        let object = |vector: Option<&Vector<'s>>| vector.map_or(NONE, |vector| vector.0.object);
        // SAFETY: the matrix and the vectors are live; null means no scaling.
        unsafe { call!(MatDiagonalScale(self.0.object, object(left), object(right))) }
    }

    /// `self <- factor self`.
    pub fn multiply_by(&mut self, factor: f64) -> Result<(), PetscError> {
        // SAFETY: the matrix is live.
        unsafe { call!(MatScale(self.0.object, factor)) }
    }

    /// Declares that the matrix is symmetric, so that factorisations may use it.
    pub fn declare_symmetric(&mut self) -> Result<(), PetscError> {
        // SAFETY: the matrix is live.
        unsafe { call!(MatSetOption(self.0.object, ffi::MAT_SYMMETRIC, 1)) }
    }

    /// `self <- self + other`.
    ///
    /// # Errors
    /// Those of PETSc, as for sizes that do not fit.
    pub fn add(&mut self, other: &Matrix<'s>) -> Result<(), PetscError> {
        // SAFETY: both matrices are live and distinct.
        unsafe {
            call!(MatAXPY(
                self.0.object,
                1.0,
                other.0.object,
                DIFFERENT_NONZERO_PATTERN
            ))
        }
    }

    /// Number of rows on all processes.
    pub fn size(&self) -> Result<usize, PetscError> {
        let (mut m, mut n) = (0, 0);
        // SAFETY: the matrix and both results are live.
        unsafe { call!(MatGetSize(self.0.object, &mut m, &mut n)) }?;
        Ok(m as usize)
    }

    /// The rows of this process.
    pub fn row_range(&self) -> Result<Range<Int>, PetscError> {
        let (mut first, mut end) = (0, 0);
        // SAFETY: the matrix and both results are live.
        unsafe { call!(MatGetOwnershipRange(self.0.object, &mut first, &mut end)) }?;
        Ok(first..end)
    }

    /// Calls `visit` with columns and values of each row of this process, in order.
    ///
    /// # Errors
    /// Those of PETSc, as for a nested matrix.
    pub fn for_each_row(&self, mut visit: impl FnMut(&[Int], &[f64])) -> Result<(), PetscError> {
        for row in self.row_range()? {
            let (mut n, mut columns, mut values) = (0, ptr::null(), ptr::null());
            // SAFETY: the row belongs to this process. Until MatRestoreRow both pointers are valid
            // for `n` entries; they may be null if there are none.
            unsafe {
                call!(MatGetRow(
                    self.0.object,
                    row,
                    &mut n,
                    &mut columns,
                    &mut values
                ))?;
                if n > 0 {
                    visit(
                        std::slice::from_raw_parts(columns, n as usize),
                        std::slice::from_raw_parts(values, n as usize),
                    );
                } else {
                    visit(&[], &[]);
                }
                call!(MatRestoreRow(
                    self.0.object,
                    row,
                    &mut n,
                    &mut columns,
                    &mut values
                ))?;
            }
        }
        Ok(())
    }

    /// Declares that `vector`, of norm one, spans the null space.
    pub fn set_null_vector(&mut self, vector: &Vector<'s>) -> Result<NullSpace<'s>, PetscError> {
        let mut space = NONE;
        // SAFETY: one live vector of norm one; PETSc adds a reference to it, and the matrix one to
        // the new space.
        unsafe {
            call!(MatNullSpaceCreate(
                world(),
                0,
                1,
                &vector.0.object,
                &mut space
            ))?;
            let space: Handle<'s> = Handle::owned(space, ffi::MatNullSpaceDestroy);
            call!(MatSetNullSpace(self.0.object, space.object))?;
            Ok(NullSpace(space))
        }
    }
}

/// A null space.
pub struct NullSpace<'s>(Handle<'s>);

impl<'s> NullSpace<'s> {
    /// Makes `vector` orthogonal to the null space.
    pub fn remove(&self, vector: &mut Vector<'s>) -> Result<(), PetscError> {
        // SAFETY: both objects are live.
        unsafe { call!(MatNullSpaceRemove(self.0.object, vector.0.object)) }
    }
}
