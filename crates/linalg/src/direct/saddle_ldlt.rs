//! Direct solution of the saddle-point system.

use super::factor::Precision;
use super::saddle_factor::SaddleFactor;
use crate::vector::{axpy, norm, subtract_from};
use crate::{
    KrylovParams, LinalgError, LinearOperator, Preconditioner, PreconditionerKind, SaddleSystem,
    SolveReport, fgmres,
};

/// Parameters of the direct solver.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct DirectParams {
    /// Precision of the factors, [`Precision::Single`] by default; residuals and solutions are
    /// always f64.
    pub precision: Precision,
    /// Shift of the pressure block, which becomes `-shift diag(M_p)`; 1e-4 by default.
    ///
    /// The Schur complement equals `M_p` up to a factor of six, so a refinement step reduces the
    /// error by about `shift`, until rounding errors dominate, which small pivots amplify.
    pub shift: f64,
    /// Bound on the true `||b - A x|| / ||b||`; 1e-12 by default.
    pub rel_tol: f64,
    /// Largest number of solves with the factor; 30 by default.
    pub max_refinements: usize,
}

impl Default for DirectParams {
    fn default() -> Self {
        DirectParams {
            precision: Precision::Single,
            // balances shift error and rounding error in f32: each refinement step gains four
            // digits with 283 000 dofs, four steps reach 1e-15
            shift: 1e-4,
            rel_tol: 1e-12,
            max_refinements: 30,
        }
    }
}

impl DirectParams {
    /// Parameters for systems that are too ill-conditioned for f32: factors in f64.
    ///
    /// Factors in f64 take twice the memory and time; one or two refinement steps suffice.
    pub fn double() -> Self {
        DirectParams {
            precision: Precision::Double,
            // a step gains eight digits
            shift: 1e-8,
            ..DirectParams::default()
        }
    }
}

/// Refinement steps before the true residual is computed: more than any well-posed system needs.
const ITERATIONS_PER_CYCLE: usize = 10;

/// Direct solver: `L D L^T` factors with a shifted pressure block, and refinement.
///
/// The border is eliminated by its Schur complement, dense and factorised with pivoting.
///
/// `[K (x) I3, B^T; B, -shift diag(M_p)]` is quasi-definite, so it has such factors in any
/// elimination order (Vanderbei 1995); the order is nested dissection of the graph of velocity
/// nodes and pressures. Refinement on the true system, accelerated by [`fgmres`], removes the shift
/// and the rounding errors of factors in f32. In enclosed flow each correction has zero mean
/// pressure.
///
/// Cost: `N^1.4` memory and `N^1.8` time for N dofs; 283 000 dofs take a minute of processor time
/// and 2.3 GB for 574 million nonzeros. [`BlockTriangular`](crate::BlockTriangular) with a
/// [`Multigrid`](crate::Multigrid) of [`MultigridParams::direct`](crate::MultigridParams::direct),
/// which iterates on the pressure, takes a quarter of the memory, a third of the time and 25
/// iterations to 1e-12.
pub struct SaddleLdlt {
    system: SaddleSystem,
    krylov: KrylovParams,
    factor: SaddleFactor,
}

setters!(DirectParams {
    with_precision(precision: Precision),
    with_shift(shift: f64),
    with_rel_tol(rel_tol: f64),
    with_max_refinements(max_refinements: usize),
});

impl SaddleLdlt {
    /// Orders and factorises `system`, whose matrices the solver shares.
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] for a singular block or lack of memory,
    /// [`LinalgError::Parameter`], [`LinalgError::ConstrainedDofs`], [`LinalgError::NotSymmetric`].
    pub fn factor(system: &SaddleSystem, params: &DirectParams) -> Result<Self, LinalgError> {
        let (velocity, method) = (system.velocity_block(), "the direct solver");
        velocity.constrained_dofs().refuse(method)?;
        velocity.require_symmetric_stiffness(method)?;
        for (name, value) in [("shift", params.shift), ("rel_tol", params.rel_tol)] {
            if !(value > 0.0 && value < 1.0) {
                let range = "between 0 and 1";
                return Err(LinalgError::Parameter { name, value, range });
            }
        }
        Ok(SaddleLdlt {
            system: system.clone(),
            krylov: KrylovParams::default()
                .with_rel_tol(params.rel_tol)
                .with_max_iterations(params.max_refinements)
                .with_restart(ITERATIONS_PER_CYCLE),
            factor: SaddleFactor::new(system, params.shift, params.precision)?,
        })
    }

    /// Number of nonzeros of the factor.
    pub fn nnz(&self) -> usize {
        self.factor.nnz()
    }

    /// Bytes of the factor.
    pub fn bytes(&self) -> usize {
        self.factor.bytes()
    }

    /// Solves `A x = b`, refining until the true residual is at most `rel_tol`.
    ///
    /// One more step then reduces it to the level of rounding. `iterations` of the report counts
    /// solves with the factor. In enclosed flow the pressure has zero mean over its dofs.
    ///
    /// # Errors
    /// Those of [`fgmres`]; [`LinalgError::Stagnated`] if f32 does not suffice: use
    /// [`DirectParams::double`].
    pub fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<SolveReport, LinalgError> {
        x.fill(0.0);
        let mut report = fgmres(&self.system, &mut self.factor, b, x, &self.krylov)?;
        if report.true_rel_residual > 0.0 {
            self.polish(b, x, &mut report);
        }
        // basis vectors in f32 reintroduce a constant pressure, which does not appear in the
        // residual
        self.factor.remove_constant(x);
        Ok(report)
    }

    /// Does one more refinement step, and keeps it if the residual decreases.
    fn polish(&mut self, b: &[f64], x: &mut [f64], report: &mut SolveReport) {
        let [mut r, mut polished] = [(); 2].map(|()| vec![0.0; b.len()]);
        self.system.apply(x, &mut r);
        subtract_from(b, &mut r);
        self.factor.apply(&r, &mut polished);
        axpy(1.0, x, &mut polished);
        self.system.apply(&polished, &mut r);
        subtract_from(b, &mut r);
        let residual = norm(&r) / norm(b);
        report.iterations += 1;
        if residual < report.true_rel_residual {
            x.copy_from_slice(&polished);
            report.true_rel_residual = residual;
        }
        report.history.push(report.true_rel_residual);
    }
}

/// One solve with the factor, without refinement: for systems near the one that was factorised.
impl Preconditioner for SaddleLdlt {
    fn size(&self) -> usize {
        self.factor.size()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.factor.apply(r, z);
    }

    fn kind(&self) -> PreconditionerKind {
        self.factor.kind()
    }
}
