//! Start and end of PETSc, and its messages of errors.

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::marker::PhantomData;
use std::mem::ManuallyDrop;
use std::ptr;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::PetscError;
use crate::ffi::{self, Code, Comm};

/// Whether a session was started in this process: MPI cannot be started twice.
static STARTED: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// Message of the first error since the last one that was reported.
    static MESSAGE: RefCell<Option<String>> = const { RefCell::new(None) };
    /// Number of this process and number of processes, while this thread has an active session.
    static ACTIVE: Cell<Option<(usize, usize)>> = const { Cell::new(None) };
}

/// PETSc and MPI from initialisation to finalisation, on the communicator of all processes.
pub struct Session {
    ranks: usize,
    rank: usize,
    /// Handles and sums belong to the thread that started the session.
    thread: PhantomData<*const ()>,
}

impl Session {
    /// Initialises MPI and PETSc with options such as `-log_view` or `-motion_ksp_view`.
    ///
    /// # Errors
    /// [`PetscError::SecondSession`], and those of PETSc for options that it cannot read.
    pub fn start(options: &[String]) -> Result<Self, PetscError> {
        if STARTED.swap(true, Ordering::SeqCst) {
            return Err(PetscError::SecondSession);
        }
        // A word with a zero byte cannot come from a command line.
        let words = [String::from("swim-petsc")].into_iter();
        let words: Vec<CString> = (words.chain(options.iter().cloned()))
            .filter_map(|word| CString::new(word).ok())
            .collect();
        let mut pointers: Vec<*mut c_char> = (words.iter())
            .map(|word| word.as_ptr().cast_mut())
            .chain([ptr::null_mut()])
            .collect();
        let mut count = words.len() as c_int;
        let mut arguments = pointers.as_mut_ptr();
        // SAFETY: `arguments` is a list of `count` strings that ends with a null pointer, as that
        // of `main`; PETSc copies them. No file of options and no help text are given.
        unsafe {
            call!(PetscInitialize(
                &mut count,
                &mut arguments,
                ptr::null(),
                ptr::null()
            ))
        }?;
        // SAFETY: the handler keeps no pointer, and needs no context.
        unsafe {
            call!(PetscPushErrorHandler(
                Some(remember_message),
                ptr::null_mut()
            ))
        }?;
        let (mut rank, mut ranks) = (0, 1);
        // SAFETY: MPI is initialised, the communicator valid, both results live.
        unsafe {
            ffi::MPI_Comm_rank(world(), &mut rank);
            ffi::MPI_Comm_size(world(), &mut ranks);
        }
        // On one process PETSc's types of matrices do not fit to hypre's products.
        if ranks > 1 {
            choose_galerkin_products()?;
        }
        ACTIVE.set(Some((rank as usize, ranks as usize)));
        Ok(Self {
            ranks: ranks as usize,
            rank: rank as usize,
            thread: PhantomData,
        })
    }

    /// Number of this process.
    pub fn rank(&self) -> usize {
        self.rank
    }

    /// Number of processes.
    pub fn ranks(&self) -> usize {
        self.ranks
    }

    /// Ends all processes with an exit code, for an error that only some of them know.
    pub fn abort(&self, exit_code: u8) -> ! {
        // SAFETY: MPI is initialised. The call does not return; if it did, this process ends.
        unsafe { ffi::MPI_Abort(world(), c_int::from(exit_code)) };
        std::process::exit(i32::from(exit_code))
    }

    /// Calls `task` with the session of this thread.
    ///
    /// # Errors
    /// [`PetscError::NoSession`], and those of `task`.
    pub(crate) fn with_current<T>(
        task: impl FnOnce(&Session) -> Result<T, PetscError>,
    ) -> Result<T, PetscError> {
        let (rank, ranks) = ACTIVE.get().ok_or(PetscError::NoSession)?;
        // A copy that does not end the session. The session cannot end during the call, because it
        // belongs to this thread.
        task(&ManuallyDrop::new(Self {
            ranks,
            rank,
            thread: PhantomData,
        }))
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        ACTIVE.set(None);
        // SAFETY: no handle is left, because all of them borrow the session. An error code at this
        // point has no receiver.
        unsafe { ffi::PetscFinalize() };
    }
}

/// Has Galerkin products computed by hypre, if PETSc has it and no option says otherwise.
///
/// The rows of the border have a nonzero per node near a body. PETSc's own products sort each row
/// into a list, which takes a time that is quadratic in its length: 41 s of set-up at two million
/// dofs, where hypre takes 2.5 s (two processes, Nov 2026).
fn choose_galerkin_products() -> Result<(), PetscError> {
    let option = c"-matptap_via";
    let (has_hypre, mut is_given) = (has_hypre()?, 0);
    // SAFETY: all strings end with a zero byte and are copied; the result is live; null means the
    // options of the command line, without a prefix.
    unsafe {
        let (options, prefix) = (ptr::null_mut(), ptr::null());
        call!(PetscOptionsHasName(
            options,
            prefix,
            option.as_ptr(),
            &mut is_given
        ))?;
        if has_hypre && is_given == 0 {
            call!(PetscOptionsSetValue(
                options,
                option.as_ptr(),
                c"hypre".as_ptr()
            ))?;
        }
    }
    Ok(())
}

/// Whether PETSc was built with hypre.
pub(super) fn has_hypre() -> Result<bool, PetscError> {
    let mut has_hypre = 0;
    // SAFETY: the string ends with a zero byte and the result is live.
    unsafe { call!(PetscHasExternalPackage(c"hypre".as_ptr(), &mut has_hypre)) }?;
    Ok(has_hypre != 0)
}

/// The communicator of all processes.
pub(super) fn world() -> Comm {
    // SAFETY: PETSc sets the variable when it is initialised and nothing changes it afterwards.
    unsafe { ffi::PETSC_COMM_WORLD }
}

/// The message of the last error, or PETSc's text for its code.
pub(super) fn take_message(code: Code) -> String {
    if let Some(message) = MESSAGE.take() {
        return message;
    }
    let mut text = ptr::null();
    // SAFETY: `text` is live; the message for the last error itself is not requested.
    unsafe { ffi::PetscErrorMessage(code, &mut text, ptr::null_mut()) };
    // SAFETY: the text is null or one of PETSc's messages, which are never freed.
    unsafe { string(text) }.unwrap_or_else(|| "no message".to_owned())
}

/// Copy of a string of PETSc; none for a null pointer.
///
/// # Safety
/// The pointer is null, or its string ends with a zero byte and lives during the call.
unsafe fn string(text: *const c_char) -> Option<String> {
    // SAFETY: the pointer is not null, and the caller promises the rest.
    let copy = || {
        unsafe { CStr::from_ptr(text) }
            .to_string_lossy()
            .into_owned()
    };
    (!text.is_null()).then(copy)
}

/// Keeps the message of the function in which an error arises; its callers pass the code on.
unsafe extern "C" fn remember_message(
    _: Comm,
    _: c_int,
    function: *const c_char,
    _: *const c_char,
    code: Code,
    _: c_int,
    message: *const c_char,
    _: *mut c_void,
) -> Code {
    // SAFETY: PETSc passes null or strings that end with a zero byte and live during the call.
    let (message, function) = unsafe { (string(message), string(function)) };
    if let Some(message) = message.filter(|message| !message.trim().is_empty()) {
        let function = function.unwrap_or_default();
        MESSAGE.with_borrow_mut(|kept| {
            kept.get_or_insert_with(|| format!("{} ({function})", message.trim()));
        });
    }
    code
}

/// Returns freed memory to the operating system, where the C library can.
///
/// Assembly and set-up free large arrays between arrays that stay. Without this call the processes
/// hold a tenth more memory at the end.
pub fn release_memory() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the function of the GNU C library has no preconditions.
    unsafe {
        ffi::malloc_trim(0);
    }
}
