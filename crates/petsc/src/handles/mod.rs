//! Safe handles on PETSc's objects: they are freed when dropped, and every error code is an error.
//!
//! Together with `ffi.rs` this is the only folder with unsafe code. All handles borrow the
//! [`Session`], so that none outlives PETSc. They are neither `Send` nor `Sync`: PETSc is called on
//! one thread per process.
//!
//! Functions that return a [`PetscError`] pass on the errors of PETSc; sections on errors are
//! written where there are others, or where a caller can cause them.
#![allow(unsafe_code)]

/// Calls a function of PETSc or MPI; an error code becomes an error that names the function.
macro_rules! call {
    ($function:ident($($argument:expr),*)) => {
        $crate::handles::check(stringify!($function), $crate::ffi::$function($($argument),*))
    };
}

/// Methods that call one function of PETSc each, whose first argument is the object of the handle.
macro_rules! methods {
    ($($(#[$doc:meta])*
       $name:ident($($argument:ident: $type:ty),*) = $function:ident($($passed:expr),*);)*) => {
        $(
            $(#[$doc])*
            pub fn $name(&self $(, $argument: $type)*) -> Result<(), PetscError> {
                // SAFETY: the handle's object and those of all arguments are live. Vectors are
                // distinct, because one is borrowed mutably. PETSc copies names and numbers, and
                // adds references to the objects that it keeps.
                unsafe { call!($function(self.0.object $(, $passed)*)) }
            }
        )*
    };
}

mod exchange;
mod krylov;
mod matrix;
mod one_thread;
mod session;
mod vector;

pub use exchange::Exchange;
pub use krylov::Krylov;
pub use matrix::{Matrix, NullSpace, Rows};
pub use one_thread::OneThread;
pub use session::{Session, release_memory};
pub use vector::Vector;

use std::ffi::{CStr, c_void};
use std::marker::PhantomData;

use crate::PetscError;
use crate::ffi::{Code, Int, Object};

/// A reference-counted object of PETSc, with the function that releases it.
struct Handle<'s> {
    object: Object,
    destroy: unsafe extern "C" fn(*mut Object) -> Code,
    session: PhantomData<&'s Session>,
}

impl<'s> Handle<'s> {
    /// Takes over a reference that PETSc has counted for the caller.
    ///
    /// # Safety
    /// `object` is live, nobody else releases this reference, and `destroy` belongs to its class.
    unsafe fn owned(object: Object, destroy: unsafe extern "C" fn(*mut Object) -> Code) -> Self {
        Self {
            object,
            destroy,
            session: PhantomData,
        }
    }

    /// Adds a reference to an object that PETSc lends.
    ///
    /// # Safety
    /// `object` is live, and `destroy` belongs to its class.
    unsafe fn shared(
        object: Object,
        destroy: unsafe extern "C" fn(*mut Object) -> Code,
    ) -> Result<Self, PetscError> {
        // SAFETY: `object` is a live object of PETSc, which counts references in its header; the
        // added one belongs to the handle.
        unsafe {
            call!(PetscObjectReference(object))?;
            Ok(Self::owned(object, destroy))
        }
    }
}

impl Drop for Handle<'_> {
    fn drop(&mut self) {
        // SAFETY: the handle owns one reference, and the session is still active, because the
        // handle borrows it. An error code at this point has no receiver.
        unsafe { (self.destroy)(&mut self.object) };
    }
}

/// Turns an error code of PETSc into an error with the message of the innermost function.
fn check(function: &'static str, code: Code) -> Result<(), PetscError> {
    if code == 0 {
        return Ok(());
    }
    Err(PetscError::Call {
        function,
        code,
        message: session::take_message(code),
    })
}

/// A number as PETSc's integer.
fn int(what: &'static str, number: usize) -> Result<Int, PetscError> {
    Int::try_from(number).map_err(|_| PetscError::TooLarge {
        what,
        found: number,
        bits: Int::BITS,
    })
}

/// Name of a type or a prefix for PETSc, which copies it.
type Name = CStr;

/// The null pointer as an object.
const NONE: Object = std::ptr::null_mut::<c_void>();
