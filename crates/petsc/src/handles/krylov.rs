//! Krylov and other iterative methods.

use super::session::world;
use super::{Handle, Matrix, NONE, Name, Preconditioner, Session, Vector, check, int};
use crate::PetscError;
use crate::ffi::{self, DEFAULT_REAL, KSP_NORM_NONE, KSP_NORM_UNPRECONDITIONED};

/// A solver of a linear system: a method and a preconditioner (PETSc's KSP).
pub struct Krylov<'s>(Handle<'s>);

impl<'s> Krylov<'s> {
    /// A solver without a system.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn new(_: &'s Session) -> Result<Self, PetscError> {
        let mut object = NONE;
        // SAFETY: the communicator is valid and `object` live.
        check("KSPCreate", unsafe { ffi::KSPCreate(world(), &mut object) })?;
        Ok(Self(Handle::owned(object, ffi::KSPDestroy)))
    }

    /// A solver that PETSc lends.
    pub(super) fn shared(object: ffi::Object) -> Result<Self, PetscError> {
        Ok(Self(Handle::shared(object, ffi::KSPDestroy)?))
    }

    /// The object of PETSc.
    pub(super) fn object(&self) -> ffi::Object {
        self.0.object
    }

    /// Solves with `a`; `p` is the matrix from which preconditioners are built.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn set_operators(&self, a: &Matrix<'s>, p: &Matrix<'s>) -> Result<(), PetscError> {
        // SAFETY: all objects are live; PETSc adds references to the matrices.
        check("KSPSetOperators", unsafe {
            ffi::KSPSetOperators(self.0.object, a.0.object, p.0.object)
        })
    }

    /// Selects the method.
    ///
    /// # Errors
    /// Those of PETSc for a name that it does not know.
    pub fn set_type(&self, kind: &Name) -> Result<(), PetscError> {
        // SAFETY: the solver is live; PETSc copies the name.
        check("KSPSetType", unsafe {
            ffi::KSPSetType(self.0.object, kind.as_ptr())
        })
    }

    /// A fixed number of steps without norms: a linear map.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn set_steps(&self, steps: usize) -> Result<(), PetscError> {
        self.set_tolerance(DEFAULT_REAL, steps)?;
        // SAFETY: the solver is live.
        check("KSPSetNormType", unsafe {
            ffi::KSPSetNormType(self.0.object, KSP_NORM_NONE)
        })
    }

    /// Relative tolerance and largest number of iterations.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn set_tolerance(&self, rtol: f64, iterations: usize) -> Result<(), PetscError> {
        let its = int("iterations", iterations)?;
        // SAFETY: the solver is live. An absolute tolerance of the smallest number never applies.
        check("KSPSetTolerances", unsafe {
            ffi::KSPSetTolerances(self.0.object, rtol, f64::MIN_POSITIVE, DEFAULT_REAL, its)
        })
    }

    /// Stops by the norm of the residual, without the preconditioner.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn stop_by_true_residual(&self) -> Result<(), PetscError> {
        // SAFETY: the solver is live.
        check("KSPSetNormType", unsafe {
            ffi::KSPSetNormType(self.0.object, KSP_NORM_UNPRECONDITIONED)
        })
    }

    /// Starts from the given vector instead of zero.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn start_from_guess(&self) -> Result<(), PetscError> {
        // SAFETY: the solver is live.
        check("KSPSetInitialGuessNonzero", unsafe {
            ffi::KSPSetInitialGuessNonzero(self.0.object, 1)
        })
    }

    /// Number of basis vectors between restarts of GMRES.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn set_restart(&self, restart: usize) -> Result<(), PetscError> {
        let restart = int("basis vectors", restart)?;
        // SAFETY: the solver is live; for other methods the call has no effect.
        check("KSPGMRESSetRestart", unsafe {
            ffi::KSPGMRESSetRestart(self.0.object, restart)
        })
    }

    /// Interval of eigenvalues on which a Chebyshev method is small.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn set_eigenvalues(&self, smallest: f64, largest: f64) -> Result<(), PetscError> {
        // SAFETY: the solver is live.
        check("KSPChebyshevSetEigenvalues", unsafe {
            ffi::KSPChebyshevSetEigenvalues(self.0.object, largest, smallest)
        })
    }

    /// Interval of a Chebyshev method as multiples of the largest eigenvalue, which is estimated.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn estimate_eigenvalues(&self, lower: f64, upper: f64) -> Result<(), PetscError> {
        // SAFETY: the solver is live.
        check("KSPChebyshevEstEigSet", unsafe {
            ffi::KSPChebyshevEstEigSet(self.0.object, 0.0, lower, 0.0, upper)
        })
    }

    /// Ends the estimation of eigenvalues after a set-up, and frees its vectors.
    ///
    /// The interval stays. For other methods the call has no effect.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn keep_eigenvalues(&self) -> Result<(), PetscError> {
        // SAFETY: the solver is live. Four zeros end the estimation.
        check("KSPChebyshevEstEigSet", unsafe {
            ffi::KSPChebyshevEstEigSet(self.0.object, 0.0, 0.0, 0.0, 0.0)
        })
    }

    /// Prefix of the options of this solver, such as `motion_`.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn set_prefix(&self, prefix: &Name) -> Result<(), PetscError> {
        // SAFETY: the solver is live; PETSc copies the prefix.
        check("KSPSetOptionsPrefix", unsafe {
            ffi::KSPSetOptionsPrefix(self.0.object, prefix.as_ptr())
        })
    }

    /// Reads the options of the command line.
    ///
    /// # Errors
    /// Those of PETSc for options that it cannot read.
    pub fn read_options(&self) -> Result<(), PetscError> {
        // SAFETY: the solver is live.
        check("KSPSetFromOptions", unsafe {
            ffi::KSPSetFromOptions(self.0.object)
        })
    }

    /// Sets up method and preconditioner.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn set_up(&self) -> Result<(), PetscError> {
        // SAFETY: the solver is live.
        check("KSPSetUp", unsafe { ffi::KSPSetUp(self.0.object) })
    }

    /// Solves for `b`; whether the method converged is told by [`Krylov::reason`].
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn solve(&self, b: &Vector<'s>, x: &mut Vector<'s>) -> Result<(), PetscError> {
        // SAFETY: the solver and both vectors are live, and the vectors distinct.
        check("KSPSolve", unsafe {
            ffi::KSPSolve(self.0.object, b.0.object, x.0.object)
        })
    }

    /// The preconditioner.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn preconditioner(&self) -> Result<Preconditioner<'s>, PetscError> {
        let mut object = NONE;
        // SAFETY: the solver is live and lends its preconditioner.
        check("KSPGetPC", unsafe {
            ffi::KSPGetPC(self.0.object, &mut object)
        })?;
        Preconditioner::shared(object)
    }

    /// Why the last solve ended: `KSPConvergedReason`, negative without convergence.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn reason(&self) -> Result<i32, PetscError> {
        let mut reason = 0;
        // SAFETY: solver and result are live.
        check("KSPGetConvergedReason", unsafe {
            ffi::KSPGetConvergedReason(self.0.object, &mut reason)
        })?;
        Ok(reason)
    }

    /// Number of iterations of the last solve.
    ///
    /// # Errors
    /// Those of PETSc.
    pub fn iterations(&self) -> Result<usize, PetscError> {
        let mut iterations = 0;
        // SAFETY: solver and result are live.
        check("KSPGetIterationNumber", unsafe {
            ffi::KSPGetIterationNumber(self.0.object, &mut iterations)
        })?;
        Ok(iterations as usize)
    }
}
