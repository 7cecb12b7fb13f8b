//! Declarations of the functions of PETSc 3.18 and of MPI that this crate calls.
//!
//! Types and values are those of PETSc's headers; names too. `build.rs` has checked that this PETSc
//! has real numbers in double precision.
#![allow(unsafe_code, non_upper_case_globals, missing_docs)]

use std::ffi::{c_char, c_int, c_void};

#[cfg(not(petsc_64_bit))]
pub type Int = i32;
#[cfg(petsc_64_bit)]
pub type Int = i64;

/// A pointer in Open MPI, a number in MPICH.
#[cfg(not(petsc_mpich))]
pub type Comm = *mut c_void;
#[cfg(petsc_mpich)]
pub type Comm = c_int;

/// As [`Comm`].
pub type Datatype = Comm;
#[cfg(not(petsc_mpich))]
pub const NO_DATATYPE: Datatype = std::ptr::null_mut();
#[cfg(petsc_mpich)]
pub const NO_DATATYPE: Datatype = 0;

pub type Code = c_int;
/// Handles are pointers to structs that only PETSc knows.
pub type Object = *mut c_void;
pub type Handler = unsafe extern "C" fn(
    Comm,
    c_int,
    *const c_char,
    *const c_char,
    Code,
    c_int,
    *const c_char,
    *mut c_void,
) -> Code;
pub type ShellApply = unsafe extern "C" fn(Object, Object, Object) -> Code;
pub type ShellDestroy = unsafe extern "C" fn(Object) -> Code;

/// `PETSC_DETERMINE`, also `PETSC_DECIDE` and `PETSC_DEFAULT` where a size or tolerance is meant.
pub const DETERMINE: Int = -1;
pub const DEFAULT_REAL: f64 = -2.0;
pub const PETSC_DOUBLE: c_int = 1;
pub const SCATTER_FORWARD: c_int = 0;
pub const INSERT_VALUES: c_int = 1;
pub const NORM_2: c_int = 1;
pub const MAT_INITIAL_MATRIX: c_int = 0;
pub const MAT_SYMMETRIC: c_int = 1;
pub const DIFFERENT_NONZERO_PATTERN: c_int = 0;
pub const KSP_NORM_NONE: c_int = 0;
pub const KSP_NORM_UNPRECONDITIONED: c_int = 2;
pub const PC_COMPOSITE_ADDITIVE: c_int = 0;
pub const PC_COMPOSITE_SCHUR: c_int = 4;
pub const PC_FIELDSPLIT_SCHUR_PRE_USER: c_int = 3;
pub const PC_FIELDSPLIT_SCHUR_FACT_UPPER: c_int = 2;
pub const PC_MG_GALERKIN_NONE: c_int = 3;

#[rustfmt::skip]
unsafe extern "C" {
    pub static PETSC_COMM_WORLD: Comm;
    pub fn MPI_Comm_rank(comm: Comm, rank: *mut c_int) -> c_int;
    pub fn MPI_Comm_size(comm: Comm, size: *mut c_int) -> c_int;
    pub fn MPI_Abort(comm: Comm, code: c_int) -> c_int;
    pub fn MPI_Alltoallv(sent: *const c_void, counts: *const c_int, starts: *const c_int, kind: Datatype, received: *mut c_void, received_counts: *const c_int, received_starts: *const c_int, received_kind: Datatype, comm: Comm) -> c_int;

    pub fn PetscInitialize(argc: *mut c_int, argv: *mut *mut *mut c_char, file: *const c_char, help: *const c_char) -> Code;
    pub fn PetscFinalize() -> Code;
    pub fn PetscHasExternalPackage(name: *const c_char, has: *mut c_int) -> Code;
    pub fn PetscOptionsHasName(options: Object, prefix: *const c_char, name: *const c_char, has: *mut c_int) -> Code;
    pub fn PetscOptionsSetValue(options: Object, name: *const c_char, value: *const c_char) -> Code;
    pub fn PetscPushErrorHandler(handler: Option<Handler>, context: *mut c_void) -> Code;
    pub fn PetscErrorMessage(code: c_int, text: *mut *const c_char, specific: *mut *mut c_char) -> Code;
    pub fn PetscObjectReference(object: Object) -> Code;
    pub fn PetscDataTypeToMPIDataType(kind: c_int, out: *mut Datatype) -> Code;

    pub fn VecCreateMPI(comm: Comm, local: Int, global: Int, v: *mut Object) -> Code;
    pub fn VecDestroy(v: *mut Object) -> Code;
    pub fn VecGetLocalSize(v: Object, n: *mut Int) -> Code;
    pub fn VecGetArray(v: Object, a: *mut *mut f64) -> Code;
    pub fn VecRestoreArray(v: Object, a: *mut *mut f64) -> Code;
    pub fn VecGetArrayRead(v: Object, a: *mut *const f64) -> Code;
    pub fn VecRestoreArrayRead(v: Object, a: *mut *const f64) -> Code;
    pub fn VecNorm(v: Object, kind: c_int, norm: *mut f64) -> Code;
    pub fn VecAYPX(y: Object, alpha: f64, x: Object) -> Code;
    pub fn VecScatterCreateToAll(v: Object, scatter: *mut Object, all: *mut Object) -> Code;
    pub fn VecScatterBegin(s: Object, x: Object, y: Object, mode: c_int, direction: c_int) -> Code;
    pub fn VecScatterEnd(s: Object, x: Object, y: Object, mode: c_int, direction: c_int) -> Code;
    pub fn VecScatterDestroy(s: *mut Object) -> Code;

    pub fn MatCreateMPIAIJWithArrays(comm: Comm, m: Int, n: Int, gm: Int, gn: Int, i: *const Int, j: *const Int, a: *const f64, mat: *mut Object) -> Code;
    pub fn MatCreateNest(comm: Comm, nr: Int, rows: *const Object, nc: Int, cols: *const Object, blocks: *const Object, mat: *mut Object) -> Code;
    pub fn MatNestGetISs(mat: Object, rows: *mut Object, cols: *mut Object) -> Code;
    pub fn MatSetOption(mat: Object, option: c_int, flag: c_int) -> Code;
    pub fn MatDestroy(mat: *mut Object) -> Code;
    pub fn MatMult(mat: Object, x: Object, y: Object) -> Code;
    pub fn MatTranspose(mat: Object, reuse: c_int, out: *mut Object) -> Code;
    pub fn MatCreateTranspose(mat: Object, out: *mut Object) -> Code;
    pub fn MatMatMult(a: Object, b: Object, reuse: c_int, fill: f64, c: *mut Object) -> Code;
    pub fn MatPtAP(a: Object, p: Object, reuse: c_int, fill: f64, c: *mut Object) -> Code;
    pub fn MatDiagonalScale(mat: Object, left: Object, right: Object) -> Code;
    pub fn MatAXPY(y: Object, a: f64, x: Object, structure: c_int) -> Code;
    pub fn MatScale(mat: Object, a: f64) -> Code;
    pub fn MatConvert(mat: Object, kind: *const c_char, reuse: c_int, out: *mut Object) -> Code;
    pub fn MatGetSize(mat: Object, m: *mut Int, n: *mut Int) -> Code;
    pub fn MatGetOwnershipRange(mat: Object, first: *mut Int, end: *mut Int) -> Code;
    pub fn MatGetRow(mat: Object, row: Int, n: *mut Int, cols: *mut *const Int, values: *mut *const f64) -> Code;
    pub fn MatRestoreRow(mat: Object, row: Int, n: *mut Int, cols: *mut *const Int, values: *mut *const f64) -> Code;
    pub fn MatNullSpaceCreate(comm: Comm, constants: c_int, n: Int, vectors: *const Object, space: *mut Object) -> Code;
    pub fn MatNullSpaceRemove(space: Object, v: Object) -> Code;
    pub fn MatNullSpaceDestroy(space: *mut Object) -> Code;
    pub fn MatSetNullSpace(mat: Object, space: Object) -> Code;

    pub fn KSPCreate(comm: Comm, ksp: *mut Object) -> Code;
    pub fn KSPDestroy(ksp: *mut Object) -> Code;
    pub fn KSPSetType(ksp: Object, kind: *const c_char) -> Code;
    pub fn KSPSetOperators(ksp: Object, a: Object, p: Object) -> Code;
    pub fn KSPSetTolerances(ksp: Object, rtol: f64, atol: f64, dtol: f64, its: Int) -> Code;
    pub fn KSPSetNormType(ksp: Object, norm: c_int) -> Code;
    pub fn KSPSetInitialGuessNonzero(ksp: Object, nonzero: c_int) -> Code;
    pub fn KSPSetOptionsPrefix(ksp: Object, prefix: *const c_char) -> Code;
    pub fn KSPSetFromOptions(ksp: Object) -> Code;
    pub fn KSPSetUp(ksp: Object) -> Code;
    pub fn KSPSolve(ksp: Object, b: Object, x: Object) -> Code;
    pub fn KSPGetPC(ksp: Object, pc: *mut Object) -> Code;
    pub fn KSPGetConvergedReason(ksp: Object, reason: *mut c_int) -> Code;
    pub fn KSPGetIterationNumber(ksp: Object, its: *mut Int) -> Code;
    pub fn KSPGMRESSetRestart(ksp: Object, restart: Int) -> Code;
    pub fn KSPChebyshevSetEigenvalues(ksp: Object, largest: f64, smallest: f64) -> Code;
    pub fn KSPChebyshevEstEigSet(ksp: Object, a: f64, b: f64, c: f64, d: f64) -> Code;

    pub fn PCDestroy(pc: *mut Object) -> Code;
    pub fn PCApply(pc: Object, x: Object, y: Object) -> Code;
    pub fn PCSetType(pc: Object, kind: *const c_char) -> Code;
    pub fn PCFieldSplitSetType(pc: Object, kind: c_int) -> Code;
    pub fn PCFieldSplitSetIS(pc: Object, name: *const c_char, is: Object) -> Code;
    pub fn PCFieldSplitSetSchurFactType(pc: Object, kind: c_int) -> Code;
    pub fn PCFieldSplitSetSchurPre(pc: Object, kind: c_int, mat: Object) -> Code;
    pub fn PCFieldSplitSchurGetSubKSP(pc: Object, n: *mut Int, ksps: *mut *mut Object) -> Code;
    pub fn PCMGSetLevels(pc: Object, levels: Int, comms: *mut Comm) -> Code;
    pub fn PCMGSetGalerkin(pc: Object, kind: c_int) -> Code;
    pub fn PCMGSetInterpolation(pc: Object, level: Int, p: Object) -> Code;
    pub fn PCMGGetSmoother(pc: Object, level: Int, ksp: *mut Object) -> Code;
    pub fn PCMGGetCoarseSolve(pc: Object, ksp: *mut Object) -> Code;
    pub fn PCRedundantGetKSP(pc: Object, ksp: *mut Object) -> Code;
    pub fn PCFactorSetMatSolverType(pc: Object, kind: *const c_char) -> Code;
    pub fn PCCompositeSetType(pc: Object, kind: c_int) -> Code;
    pub fn PCCompositeAddPCType(pc: Object, kind: *const c_char) -> Code;
    pub fn PCCompositeGetPC(pc: Object, n: Int, sub: *mut Object) -> Code;
    pub fn PCKSPGetKSP(pc: Object, ksp: *mut Object) -> Code;
    pub fn PCShellSetApply(pc: Object, apply: Option<ShellApply>) -> Code;
    pub fn PCShellSetContext(pc: Object, context: *mut c_void) -> Code;
    pub fn PCShellGetContext(pc: Object, context: *mut *mut c_void) -> Code;
    pub fn PCShellSetDestroy(pc: Object, destroy: Option<ShellDestroy>) -> Code;
    pub fn PCShellSetName(pc: Object, name: *const c_char) -> Code;

    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    pub fn malloc_trim(pad: usize) -> c_int;

    // static inline in the headers since version 3.16: it frees through this pointer
    pub static PetscTrFree: Option<unsafe extern "C" fn(*mut c_void, c_int, *const c_char, *const c_char) -> Code>;
}
