//! Direct solution of the saddle-point system.

use super::factor::Precision;
use super::saddle_factor::SaddleFactor;
use crate::vector::{axpy, norm, subtract_from};
use crate::{
    KrylovParams, LinalgError, LinearOperator, Preconditioner, SaddleSystem, SolveReport, fgmres,
};

/// Choices of the direct solver.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct DirectParams {
    /// Of the factors; residuals and solutions are always f64.
    pub precision: Precision,
    /// The pressure block becomes `-shift diag(M_p)`. The Schur complement is `M_p` up to a factor of six, so a refinement step
    /// gains about `1 / shift`, until rounding, which small pivots amplify, takes over.
    pub shift: f64,
    /// Bound on the true `||b - A x|| / ||b||`.
    pub rel_tol: f64,
    /// Solves with the factor allowed.
    pub max_refinements: usize,
}

impl Default for DirectParams {
    fn default() -> Self {
        DirectParams {
            precision: Precision::Single,
            // balances both errors in f32: a step gains four digits on 283 000 unknowns, four steps reach 1e-15
            shift: 1e-4,
            rel_tol: 1e-12,
            max_refinements: 30,
        }
    }
}

impl DirectParams {
    /// Factors in f64, twice the memory and time: one or two refinements, for systems too ill-conditioned for f32.
    pub fn double() -> Self {
        DirectParams {
            precision: Precision::Double,
            // a step gains eight digits
            shift: 1e-8,
            ..DirectParams::default()
        }
    }
}

impl DirectParams {
    /// The same parameters with another [`precision`](DirectParams::precision).
    pub fn with_precision(mut self, precision: Precision) -> Self {
        self.precision = precision;
        self
    }

    /// The same parameters with another [`shift`](DirectParams::shift).
    pub fn with_shift(mut self, shift: f64) -> Self {
        self.shift = shift;
        self
    }

    /// The same parameters with another [`rel_tol`](DirectParams::rel_tol).
    pub fn with_rel_tol(mut self, rel_tol: f64) -> Self {
        self.rel_tol = rel_tol;
        self
    }

    /// The same parameters with another [`max_refinements`](DirectParams::max_refinements).
    pub fn with_max_refinements(mut self, max_refinements: usize) -> Self {
        self.max_refinements = max_refinements;
        self
    }
}

/// Steps of refinement before a look at the true residual: more than any sound system needs.
const CYCLE: usize = 10;

/// An `L D L^T` of the fluid block with the border eliminated by a dense, pivoted Schur complement.
///
/// `[K (x) I3, B^T; B, -shift diag(M_p)]` is quasi-definite: it has such factors in any elimination order (Vanderbei 1995), here
/// METIS nested dissection of the graph of velocity nodes and pressures. The shift, and the rounding of factors in
/// f32, are removed by refinement on the true system, accelerated by [`fgmres`]. In enclosed flow the undetermined constant is
/// taken out of each correction.
///
/// Cost: `N^1.4` memory, `N^1.8` time for N unknowns; 283 000 take a minute of processor time and 2.3 GB for 574 million entries. A quarter of
/// that memory and a third of the time go where pressures may be iterated: [`BlockTriangular`](crate::BlockTriangular) with a
/// [`Multigrid`](crate::Multigrid) of [`MultigridParams::direct`](crate::MultigridParams::direct), 25 iterations to 1e-12.
pub struct SaddleLdlt {
    system: SaddleSystem,
    krylov: KrylovParams,
    factor: SaddleFactor,
}

impl SaddleLdlt {
    /// Orders and factorises.
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] for a singular block or lack of memory, [`LinalgError::Parameter`].
    pub fn factor(system: &SaddleSystem, params: &DirectParams) -> Result<Self, LinalgError> {
        system
            .velocity_block()
            .constrained_dofs()
            .refuse("the direct solver")?;
        for (name, value) in [("shift", params.shift), ("rel_tol", params.rel_tol)] {
            if !(value > 0.0 && value < 1.0) {
                let range = "between 0 and 1";
                return Err(LinalgError::Parameter { name, value, range });
            }
        }
        Ok(SaddleLdlt {
            system: system.clone(),
            krylov: KrylovParams {
                rel_tol: params.rel_tol,
                max_iterations: params.max_refinements,
                restart: CYCLE,
            },
            factor: SaddleFactor::new(system, params.shift, params.precision)?,
        })
    }

    /// Entries of the factor.
    pub fn nnz(&self) -> usize {
        self.factor.nnz()
    }

    /// Bytes of the factor.
    pub fn bytes(&self) -> usize {
        self.factor.bytes()
    }

    /// Solves `A x = b`; refines until the true residual reaches `rel_tol`, and once more, which takes it to the level of rounding.
    ///
    /// `iterations` of the report counts solves with the factor. In enclosed flow the pressure has mean zero over its unknowns.
    ///
    /// # Errors
    /// Those of [`fgmres`]; [`LinalgError::Stagnated`] where f32 does not suffice: use [`DirectParams::double`].
    pub fn solve(&mut self, b: &[f64], x: &mut [f64]) -> Result<SolveReport, LinalgError> {
        x.fill(0.0);
        let mut report = fgmres(&self.system, &mut self.factor, b, x, &self.krylov)?;
        if report.true_rel_residual > 0.0 {
            self.polish(b, x, &mut report);
        }
        // a basis rounded to f32 brings a constant back, which no residual shows
        self.factor.remove_constant(x);
        Ok(report)
    }

    /// One more step of refinement, kept if it is one.
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
