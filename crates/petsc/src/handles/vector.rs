//! Vectors that are distributed over the processes.

use std::slice;

use super::session::world;
use super::{Handle, NONE, Session, int};
use crate::PetscError;
use crate::ffi::{self, DETERMINE, INSERT_VALUES, NORM_2, SCATTER_FORWARD};

/// A vector of which each process has consecutive entries.
pub struct Vector<'s>(pub(super) Handle<'s>);

impl<'s> Vector<'s> {
    /// A vector of zeros with `local` entries on this process.
    pub fn new(_: &'s Session, local: usize) -> Result<Self, PetscError> {
        let (n, mut object) = (int("entries of a vector", local)?, NONE);
        // SAFETY: the communicator is valid and `object` live.
        unsafe {
            call!(VecCreateMPI(world(), n, DETERMINE, &mut object))?;
            Ok(Self(Handle::owned(object, ffi::VecDestroy)))
        }
    }

    /// A vector with these entries on this process.
    pub fn from_slice(session: &'s Session, local: &[f64]) -> Result<Self, PetscError> {
        let mut vector = Self::new(session, local.len())?;
        vector.set(local)?;
        Ok(vector)
    }

    /// Calls `visit` with the entries of this process.
    fn with_entries<T>(&self, visit: impl FnOnce(&mut [f64]) -> T) -> Result<T, PetscError> {
        let (mut n, mut entries) = (0, std::ptr::null_mut());
        // SAFETY: the vector is live. Between VecGetArray and VecRestoreArray `entries` points to
        // its `n` local entries, and nothing else uses them; it may be null if there are none.
        unsafe {
            call!(VecGetLocalSize(self.0.object, &mut n))?;
            call!(VecGetArray(self.0.object, &mut entries))?;
            let result = if entries.is_null() {
                visit(&mut [])
            } else {
                visit(slice::from_raw_parts_mut(entries, n as usize))
            };
            call!(VecRestoreArray(self.0.object, &mut entries))?;
            Ok(result)
        }
    }

    /// Copies the entries of this process from a slice of the same length.
    pub fn set(&mut self, local: &[f64]) -> Result<(), PetscError> {
        self.with_entries(|entries| {
            (entries.iter_mut().zip(local)).for_each(|(entry, value)| *entry = *value);
        })
    }

    /// The entries of this process.
    pub fn local(&self) -> Result<Vec<f64>, PetscError> {
        self.with_entries(|entries| entries.to_vec())
    }

    /// The entries of all processes, on every process.
    pub fn of_all(&self) -> Result<Vec<f64>, PetscError> {
        let (mut scatter, mut all) = (NONE, NONE);
        // SAFETY: the vector is live; both results are, and belong to this function, which drops
        // them by their handles.
        let (scatter, all): (Handle<'s>, _) = unsafe {
            call!(VecScatterCreateToAll(self.0.object, &mut scatter, &mut all))?;
            let scatter = Handle::owned(scatter, ffi::VecScatterDestroy);
            (scatter, Vector(Handle::owned(all, ffi::VecDestroy)))
        };
        let (s, x, y) = (scatter.object, self.0.object, all.0.object);
        // SAFETY: the scatter was created for these two vectors, which are live.
        unsafe {
            call!(VecScatterBegin(s, x, y, INSERT_VALUES, SCATTER_FORWARD))?;
            call!(VecScatterEnd(s, x, y, INSERT_VALUES, SCATTER_FORWARD))?;
        }
        all.local()
    }

    /// Euclidean norm over all processes.
    pub fn norm(&self) -> Result<f64, PetscError> {
        let mut norm = 0.0;
        // SAFETY: vector and result are live.
        unsafe { call!(VecNorm(self.0.object, NORM_2, &mut norm)) }?;
        Ok(norm)
    }

    /// `self <- x - self`.
    ///
    /// # Errors
    /// Those of PETSc, as for vectors of different lengths.
    pub fn subtract_from(&mut self, x: &Vector<'s>) -> Result<(), PetscError> {
        // SAFETY: both vectors are live and distinct, because one is borrowed mutably.
        unsafe { call!(VecAYPX(self.0.object, -1.0, x.0.object)) }
    }
}
