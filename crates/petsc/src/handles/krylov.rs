//! Krylov methods and their preconditioners: fields, multigrid, factorisations, diagonals.

use std::ffi::c_void;
use std::ptr;

use super::session::{has_hypre, world};
use super::{Handle, Matrix, NONE, Name, Session, Vector, check, int};
use crate::PetscError;
use crate::ffi::{self, Code, DEFAULT_REAL, KSP_NORM_NONE, KSP_NORM_UNPRECONDITIONED, Object};

/// A solver of a linear system: a method and a preconditioner (PETSc's KSP).
pub struct Krylov<'s>(Handle<'s>);

impl<'s> Krylov<'s> {
    /// A solver without a system.
    pub fn new(_: &'s Session) -> Result<Self, PetscError> {
        let mut object = NONE;
        // SAFETY: the communicator is valid and `object` live.
        unsafe {
            call!(KSPCreate(world(), &mut object))?;
            Ok(Self(Handle::owned(object, ffi::KSPDestroy)))
        }
    }

    /// A solver that PETSc lends.
    ///
    /// # Safety
    /// `object` is a live solver.
    pub(super) unsafe fn shared(object: Object) -> Result<Self, PetscError> {
        // SAFETY: the caller's promise.
        Ok(Self(unsafe { Handle::shared(object, ffi::KSPDestroy) }?))
    }

    /// The object of PETSc.
    pub(super) fn object(&self) -> Object {
        self.0.object
    }

    /// A fixed number of steps without norms: a linear map.
    pub fn set_steps(&self, steps: usize) -> Result<(), PetscError> {
        self.set_tolerance(DEFAULT_REAL, steps)?;
        // SAFETY: the solver is live.
        unsafe { call!(KSPSetNormType(self.0.object, KSP_NORM_NONE)) }
    }

    methods! {
        /// Solves with `a`; `p` is the matrix from which preconditioners are built.
        set_operators(a: &Matrix<'s>, p: &Matrix<'s>) = KSPSetOperators(a.0.object, p.0.object);

        /// Selects the method.
        ///
        /// # Errors
        /// Those of PETSc for a name that it does not know.
        set_type(kind: &Name) = KSPSetType(kind.as_ptr());

        /// Relative tolerance and largest number of iterations; no absolute tolerance applies.
        set_tolerance(rtol: f64, iterations: usize) = KSPSetTolerances(
            rtol, f64::MIN_POSITIVE, DEFAULT_REAL, int("iterations", iterations)?
        );

        /// Stops by the norm of the residual, without the preconditioner.
        stop_by_true_residual() = KSPSetNormType(KSP_NORM_UNPRECONDITIONED);

        /// Starts from the given vector instead of zero.
        start_from_guess() = KSPSetInitialGuessNonzero(1);

        /// Number of basis vectors between restarts of GMRES; without effect on other methods.
        set_restart(restart: usize) = KSPGMRESSetRestart(int("basis vectors", restart)?);

        /// Interval of eigenvalues on which a Chebyshev method is small.
        set_eigenvalues(smallest: f64, largest: f64) = KSPChebyshevSetEigenvalues(largest, smallest);

        /// Interval of a Chebyshev method in multiples of the estimated largest eigenvalue.
        estimate_eigenvalues(lower: f64, upper: f64) = KSPChebyshevEstEigSet(0.0, lower, 0.0, upper);

        /// Ends the estimation of eigenvalues after a set-up, and frees its vectors.
        ///
        /// The interval stays. For other methods the call has no effect.
        keep_eigenvalues() = KSPChebyshevEstEigSet(0.0, 0.0, 0.0, 0.0);

        /// Prefix of the options of this solver, such as `motion_`.
        set_prefix(prefix: &Name) = KSPSetOptionsPrefix(prefix.as_ptr());

        /// Reads the options of the command line.
        ///
        /// # Errors
        /// Those of PETSc for options that it cannot read.
        read_options() = KSPSetFromOptions();

        /// Sets up method and preconditioner.
        set_up() = KSPSetUp();

        /// Solves for `b`; whether the method converged is told by [`Krylov::reason`].
        solve(b: &Vector<'s>, x: &mut Vector<'s>) = KSPSolve(b.0.object, x.0.object);
    }

    /// The preconditioner.
    pub fn preconditioner(&self) -> Result<Preconditioner<'s>, PetscError> {
        let mut object = NONE;
        // SAFETY: the solver is live and lends its preconditioner.
        unsafe {
            call!(KSPGetPC(self.0.object, &mut object))?;
            Preconditioner::shared(object)
        }
    }

    /// Why the last solve ended: `KSPConvergedReason`, negative without convergence.
    pub fn reason(&self) -> Result<i32, PetscError> {
        let mut reason = 0;
        // SAFETY: solver and result are live.
        unsafe { call!(KSPGetConvergedReason(self.0.object, &mut reason)) }?;
        Ok(reason)
    }

    /// Number of iterations of the last solve.
    pub fn iterations(&self) -> Result<usize, PetscError> {
        let mut iterations = 0;
        // SAFETY: solver and result are live.
        unsafe { call!(KSPGetIterationNumber(self.0.object, &mut iterations)) }?;
        Ok(iterations as usize)
    }
}

/// A preconditioner (PETSc's PC), which its solver shares.
pub struct Preconditioner<'s>(Handle<'s>);

impl<'s> Preconditioner<'s> {
    /// A preconditioner that PETSc lends.
    ///
    /// # Safety
    /// `object` is a live preconditioner.
    pub(super) unsafe fn shared(object: Object) -> Result<Self, PetscError> {
        // SAFETY: the caller's promise. A solver destroys its preconditioner; a further reference
        // to it is released by the same function.
        Ok(Self(unsafe { Handle::shared(object, ffi::PCDestroy) }?))
    }

    methods! {
        /// `z <- N r`.
        apply(r: &Vector<'s>, z: &mut Vector<'s>) = PCApply(r.0.object, z.0.object);

        /// Selects the kind.
        ///
        /// # Errors
        /// Those of PETSc for a name that it does not know.
        set_type(kind: &Name) = PCSetType(kind.as_ptr());
    }

    /// One V-cycle of algebraic multigrid for a scalar elliptic matrix.
    ///
    /// That of hypre, if PETSc has it: in a channel of 60 x 6 x 6 radii the iteration then takes 37
    /// steps, with PETSc's own 41, with exact factors 31.
    pub fn set_algebraic_multigrid(&self) -> Result<(), PetscError> {
        self.set_type(match has_hypre()? {
            true => c"hypre",
            false => c"gamg",
        })
    }

    /// The upper factor of a block factorisation of `nested`, whose blocks have these names.
    ///
    /// `schur` approximates the Schur complement of the second block.
    pub fn split_by_fields(
        &self,
        nested: &Matrix<'s>,
        names: [&Name; 2],
        schur: &Matrix<'s>,
    ) -> Result<(), PetscError> {
        self.set_type(c"fieldsplit")?;
        let pc = self.0.object;
        // SAFETY: the preconditioner, the index sets and the matrix are live; PETSc copies the
        // names and adds references to the others.
        unsafe {
            for (name, set) in names.iter().zip(nested.index_sets()?) {
                call!(PCFieldSplitSetIS(pc, name.as_ptr(), set))?;
            }
            call!(PCFieldSplitSetType(pc, ffi::PC_COMPOSITE_SCHUR))?;
            let upper = ffi::PC_FIELDSPLIT_SCHUR_FACT_UPPER;
            call!(PCFieldSplitSetSchurFactType(pc, upper))?;
            let user = ffi::PC_FIELDSPLIT_SCHUR_PRE_USER;
            call!(PCFieldSplitSetSchurPre(pc, user, schur.0.object))
        }
    }

    /// Solvers of both fields of a split that is set up.
    pub fn fields(&self) -> Result<[Krylov<'s>; 2], PetscError> {
        let (mut n, mut solvers) = (0, ptr::null_mut());
        // SAFETY: the preconditioner is live. The list has `n` solvers, which the preconditioner
        // lends; it is allocated by PETSc and freed here.
        unsafe {
            call!(PCFieldSplitSchurGetSubKSP(
                self.0.object,
                &mut n,
                &mut solvers
            ))?;
            let fields = [Krylov::shared(*solvers)?, Krylov::shared(*solvers.add(1))?];
            if let Some(free) = ffi::PetscTrFree {
                let code = free(solvers.cast(), 0, c"fields".as_ptr(), c"".as_ptr());
                check("PetscFree", code)?;
            }
            Ok(fields)
        }
    }

    /// Multigrid with one more level than there are prolongations, which are given finest first.
    pub fn set_multigrid(&self, prolongations: &[Matrix<'s>]) -> Result<(), PetscError> {
        self.set_type(c"mg")?;
        let (pc, levels) = (self.0.object, int("levels", prolongations.len() + 1)?);
        // SAFETY: the preconditioner and the matrices are live; null means the communicator of all
        // processes on every level.
        unsafe {
            call!(PCMGSetLevels(pc, levels, ptr::null_mut()))?;
            call!(PCMGSetGalerkin(pc, ffi::PC_MG_GALERKIN_NONE))?;
            for (level, prolongation) in (1..levels).rev().zip(prolongations) {
                call!(PCMGSetInterpolation(pc, level, prolongation.0.object))?;
            }
        }
        Ok(())
    }

    /// The smoother of a level of multigrid; level 0 is the coarsest, which has a solver instead.
    pub fn smoother(&self, level: usize) -> Result<Krylov<'s>, PetscError> {
        let number = int("levels", level)?;
        // SAFETY: the preconditioner is live and lends its smoothers.
        unsafe {
            self.lend(|ksp| match level {
                0 => call!(PCMGGetCoarseSolve(self.0.object, ksp)),
                _ => call!(PCMGGetSmoother(self.0.object, number, ksp)),
            })
        }
    }

    /// The solver that every process applies to the gathered system.
    pub fn redundant(&self) -> Result<Krylov<'s>, PetscError> {
        self.set_type(c"redundant")?;
        // SAFETY: the preconditioner is live and lends its solver.
        unsafe { self.lend(|ksp| call!(PCRedundantGetKSP(self.0.object, ksp))) }
    }

    /// LDLT factors of a symmetric matrix by the given library.
    ///
    /// # Errors
    /// Those of PETSc, as for a library that it was built without.
    pub fn set_ldlt(&self, library: &Name) -> Result<(), PetscError> {
        self.set_type(c"cholesky")?;
        // SAFETY: the preconditioner is live; PETSc copies the name.
        unsafe { call!(PCFactorSetMatSolverType(self.0.object, library.as_ptr())) }
    }

    /// The sum of a solver and a diagonal matrix, given by its entries on this process, minus
    /// another solver.
    ///
    /// Returns the first solver.
    pub fn set_solver_and_correction(
        &self,
        (diagonal, other): (Vec<f64>, Option<&Krylov<'s>>),
    ) -> Result<Krylov<'s>, PetscError> {
        self.set_type(c"composite")?;
        let (pc, mut parts) = (self.0.object, [NONE; 2]);
        // SAFETY: the preconditioner is live; PETSc copies the names and lends the parts.
        unsafe {
            call!(PCCompositeSetType(pc, ffi::PC_COMPOSITE_ADDITIVE))?;
            for kind in [c"ksp", c"shell"] {
                call!(PCCompositeAddPCType(pc, kind.as_ptr()))?;
            }
            for (number, part) in (0..).zip(&mut parts) {
                call!(PCCompositeGetPC(pc, number, part))?;
            }
        }
        // SAFETY: the other solver and the lent parts are live; the first one lends its solver.
        unsafe {
            let other = other.map(|other| Krylov::shared(other.object()));
            Self::shared(parts[1])?.set_correction(Correction {
                diagonal,
                subtracted: other.transpose()?,
            })?;
            self.lend(|ksp| call!(PCKSPGetKSP(parts[0], ksp)))
        }
    }

    /// A diagonal matrix, given by its entries on this process.
    pub fn set_diagonal(&self, diagonal: Vec<f64>) -> Result<(), PetscError> {
        self.set_correction(Correction {
            diagonal,
            subtracted: None,
        })
    }

    fn set_correction(&self, correction: Correction<'s>) -> Result<(), PetscError> {
        self.set_type(c"shell")?;
        let (pc, context) = (self.0.object, Box::into_raw(Box::new(correction)));
        // SAFETY: the preconditioner is live. The context is a boxed correction, which
        // `apply_correction` reads and `drop_correction` frees when PETSc destroys the
        // preconditioner.
        unsafe {
            call!(PCShellSetContext(pc, context.cast()))?;
            call!(PCShellSetDestroy(pc, Some(drop_correction)))?;
            call!(PCShellSetApply(pc, Some(apply_correction)))?;
            call!(PCShellSetName(pc, c"diagonal matrix".as_ptr()))
        }
    }

    /// The solver that `call` obtains.
    ///
    /// # Safety
    /// `call` stores a live solver.
    unsafe fn lend(
        &self,
        call: impl FnOnce(*mut Object) -> Result<(), PetscError>,
    ) -> Result<Krylov<'s>, PetscError> {
        let mut object = NONE;
        call(&mut object)?;
        // SAFETY: the caller's promise.
        unsafe { Krylov::shared(object) }
    }
}

/// A diagonal matrix minus a solver, the context of a shell preconditioner.
struct Correction<'s> {
    diagonal: Vec<f64>,
    subtracted: Option<Krylov<'s>>,
}

/// The context of a shell preconditioner that `set_correction` has set.
///
/// # Safety
/// `pc` is such a preconditioner, and alive.
unsafe fn correction_of<'s>(pc: Object) -> *mut Correction<'s> {
    let mut context: *mut c_void = ptr::null_mut();
    // SAFETY: by the contract of this function.
    unsafe { ffi::PCShellGetContext(pc, &mut context) };
    context.cast()
}

/// `y <- D x - S x`, called by PETSc.
unsafe extern "C" fn apply_correction(pc: Object, x: Object, y: Object) -> Code {
    let (mut from, mut to, mut n) = (ptr::null(), ptr::null_mut(), 0);
    // SAFETY: PETSc passes a live preconditioner of this kind and two distinct live vectors. The
    // context is a correction that nothing changes. Arrays have `n` entries until they are
    // restored.
    unsafe {
        let correction = correction_of(pc);
        if correction.is_null() {
            return 1;
        }
        let subtracted = &(*correction).subtracted;
        if let Some(solver) = subtracted {
            let code = ffi::KSPSolve(solver.object(), x, y);
            if code != 0 {
                return code;
            }
        }
        let steps = [
            ffi::VecGetLocalSize(x, &mut n),
            ffi::VecGetArrayRead(x, &mut from),
            ffi::VecGetArray(y, &mut to),
        ];
        if let Some(&code) = steps.iter().find(|code| **code != 0) {
            return code;
        }
        for (i, d) in (*correction).diagonal.iter().enumerate().take(n as usize) {
            let other = if subtracted.is_some() {
                *to.add(i)
            } else {
                0.0
            };
            *to.add(i) = d * *from.add(i) - other;
        }
        let restored = ffi::VecRestoreArray(y, &mut to);
        restored.max(ffi::VecRestoreArrayRead(x, &mut from))
    }
}

/// Frees the context, called by PETSc.
unsafe extern "C" fn drop_correction(pc: Object) -> Code {
    // SAFETY: PETSc calls this function once, for a preconditioner whose context is a boxed
    // correction or not yet set.
    unsafe {
        let correction = correction_of(pc);
        if !correction.is_null() {
            drop(Box::from_raw(correction));
        }
    }
    0
}
