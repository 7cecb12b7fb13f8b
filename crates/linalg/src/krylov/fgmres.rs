//! Flexible GMRES with restarts, for one or several right-hand sides.

use super::basis::{OrthonormalBasis, RoundedBasis};
use super::complement;
use super::hessenberg::Hessenberg;
use super::progress::Progress;
use super::report::{KrylovParams, SolveReport, check_start};
use crate::csr::check_shape;
use crate::vector::{axpy, is_zero};
use crate::{LinalgError, LinearOperator, Preconditioner, PreconditionerKind};

const METHOD: &str = "FGMRES";

/// Solves `A x = b` by right-preconditioned flexible GMRES with restarts, starting from `x`.
///
/// Stops when the *true* residual `||b - A x|| / ||b||` is at most `rel_tol`. It is recomputed when
/// the recurrence predicts that it is small enough; if it is not, the iteration continues. If the
/// operator has [weights](LinearOperator::residual_weights), the method minimises the residual in
/// their norm (Essai, Numer. Algorithms 18, 1998); twice that norm, an estimate of the error, must
/// be at most `rel_tol` as well. A zero `b` gives a zero `x`.
///
/// Memory: 12 bytes per dof and iteration, allocated on demand, and 4 bytes once the residual is so
/// small that storage in f32 does not affect the result. The error of a basis vector is multiplied
/// by the residual of its step, so the precision may decrease with the residual (van den Eshof,
/// Sleijpen, SIAM J. Matrix Anal. Appl. 26, 2004). From then on, if the preconditioner is linear,
/// only the basis vectors are stored and not their preconditioned counterparts: the linear
/// combination of these basis vectors is preconditioned once at the end of the cycle. Reference:
/// Saad, SIAM J. Sci. Comput. 14 (1993).
///
/// # Errors
/// [`LinalgError::NotConverged`] and [`LinalgError::Stagnated`] (both leave the last iterate in
/// `x`), [`LinalgError::Breakdown`] for NaN, [`LinalgError::Shape`], [`LinalgError::NotFinite`],
/// [`LinalgError::Parameter`], [`LinalgError::NotNullVector`].
///
/// ```
/// use linalg::{Bordered, Csr, Identity, KrylovParams, fgmres};
/// let k = Csr::new((2, 2), vec![0, 2, 4], vec![0, 1, 0, 1], vec![2.0, -1.0, -1.0, 2.0]);
/// let a = Bordered::scalar(k)?;
/// let mut x = [0.0; 6];
/// // the right-hand side is an eigenvector with eigenvalue 1
/// let (b, params) = ([1.0, 2.0, 3.0, 1.0, 2.0, 3.0], KrylovParams::default());
/// let report = fgmres(&a, &mut Identity(6), &b, &mut x, &params)?;
/// assert!(report.true_rel_residual <= 1e-8);
/// assert!((x[5] - 3.0).abs() < 1e-7);
/// # Ok::<(), linalg::LinalgError>(())
/// ```
pub fn fgmres(
    operator: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    b: &[f64],
    x: &mut [f64],
    params: &KrylovParams,
) -> Result<SolveReport, LinalgError> {
    let mut reports = fgmres_columns(operator, preconditioner, &[b], &mut [x], params)?;
    Ok(reports.remove(0))
}

/// Solves `A x = b` for several right-hand sides, sharing the passes over the matrices.
///
/// Each solution is bitwise that of [`fgmres`], with the same iterations, tolerance and report.
///
/// Each iteration takes one pass through the preconditioner and one through the operator for all
/// right-hand sides that have not converged yet ([`LinearOperator::apply_columns`],
/// [`Preconditioner::apply_columns`]). Memory: that of [`fgmres`] for all right-hand sides at the
/// same time.
///
/// # Errors
/// Those of [`fgmres`] as soon as one right-hand side fails; [`LinalgError::Shape`] if the numbers
/// of solutions and right-hand sides differ.
///
/// ```
/// use linalg::{Bordered, Csr, Identity, KrylovParams, fgmres_columns};
/// let k = Csr::new((2, 2), vec![0, 2, 4], vec![0, 1, 0, 1], vec![2.0, -1.0, -1.0, 2.0]);
/// let a = Bordered::scalar(k)?;
/// let (mut x, mut y) = ([0.0; 6], [0.0; 6]);
/// let b: [&[f64]; 2] = [&[1.0, 2.0, 3.0, 1.0, 2.0, 3.0], &[3.0, 0.0, 0.0, -3.0, 0.0, 0.0]];
/// let params = KrylovParams::default();
/// let reports = fgmres_columns(&a, &mut Identity(6), &b, &mut [&mut x, &mut y], &params)?;
/// // the right-hand sides are eigenvectors with eigenvalues 1 and 3
/// assert!((x[5] - 3.0).abs() < 1e-7 && (y[3] + 1.0).abs() < 1e-7);
/// assert!(reports.iter().all(|report| report.true_rel_residual <= 1e-8));
/// # Ok::<(), linalg::LinalgError>(())
/// ```
pub fn fgmres_columns(
    operator: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    b: &[&[f64]],
    x: &mut [&mut [f64]],
    params: &KrylovParams,
) -> Result<Vec<SolveReport>, LinalgError> {
    check_shape("solutions", (x.len(), 1), (b.len(), 1))?;
    complement::solve(
        operator,
        preconditioner,
        b,
        x,
        params,
        |preconditioner, b, x| {
            let mut columns = Vec::with_capacity(b.len());
            for (b, x) in b.iter().zip(x) {
                columns.push(Column::new(operator, preconditioner, b, x, params)?);
            }
            iterate(operator, preconditioner, &mut columns)?;
            Ok(columns.into_iter().map(|column| column.report).collect())
        },
    )
}

/// Iterates all columns to convergence, one pass through preconditioner and operator at a time.
fn iterate(
    operator: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    columns: &mut [Column],
) -> Result<(), LinalgError> {
    while columns.iter().any(|column| column.stage != Stage::Done) {
        let (r, mut z): (Vec<_>, Vec<_>) = columns
            .iter_mut()
            .filter_map(Column::before_preconditioner)
            .unzip();
        preconditioner.apply_columns(&r, &mut z);
        columns.iter_mut().for_each(Column::after_preconditioner);
        let (x, mut y): (Vec<_>, Vec<_>) = columns
            .iter_mut()
            .filter_map(Column::before_product)
            .unzip();
        operator.apply_columns(&x, &mut y);
        for column in &mut *columns {
            column.after_product()?;
        }
    }
    Ok(())
}

/// The meaning of the next product of a column.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// The product with the solution: the true residual is computed, then a cycle begins.
    TrueResidual,
    /// The product with the basis vector of an Arnoldi step, which is stored in f32 if `single`.
    Step { single: bool },
    /// The product of `TrueResidual`, after the result of a cycle was added to the solution.
    EndOfCycle,
    /// No product: the column has converged.
    Done,
}

/// The iteration for one right-hand side.
struct Column<'a> {
    b: &'a [f64],
    x: &'a mut [f64],
    progress: Progress<'a>,
    restart: usize,
    /// Whether the preconditioner is a fixed linear map.
    fixed: bool,
    v: OrthonormalBasis<'a>,
    z: RoundedBasis,
    hessenberg: Hessenberg,
    w: Vec<f64>,
    work: Vec<f64>,
    stage: Stage,
    /// Norm of `w` if it is the next basis vector.
    size: f64,
    /// Steps of the cycle so far.
    steps: usize,
    stored: usize,
    /// The report, once the column has converged.
    report: SolveReport,
}

impl<'a> Column<'a> {
    fn new(
        operator: &'a dyn LinearOperator,
        preconditioner: &dyn Preconditioner,
        b: &'a [f64],
        x: &'a mut [f64],
        params: &'a KrylovParams,
    ) -> Result<Self, LinalgError> {
        let stage = match check_start(operator, preconditioner, b, x, params)? {
            Some(_) => Stage::TrueResidual,
            None => Stage::Done,
        };
        let restart = params.restart.min(params.max_iterations).max(1);
        let n = b.len();
        let mut column = Column {
            progress: Progress::new(METHOD, operator, params, b),
            restart,
            fixed: preconditioner.kind() <= PreconditionerKind::Linear,
            v: OrthonormalBasis::new(operator.residual_weights())
                .with_sum(operator.sum_over_processes()),
            z: RoundedBasis::new(),
            hessenberg: Hessenberg::new(),
            w: vec![0.0; n],
            work: vec![0.0; n],
            report: match stage {
                Stage::Done => SolveReport::zero(x),
                _ => SolveReport::none(),
            },
            stage,
            size: 0.0,
            steps: 0,
            stored: 0,
            b,
            x,
        };
        // The product with a zero start is `w`, which is zero.
        if column.stage == Stage::TrueResidual && is_zero(column.x, operator.sum_over_processes()) {
            column.check_convergence()?;
        }
        Ok(column)
    }

    /// The next vector to be preconditioned and the buffer for the result.
    fn before_preconditioner(&mut self) -> Option<(&[f64], &mut [f64])> {
        match self.stage {
            Stage::Step { single } => {
                self.v.store(self.steps, &self.w, self.size, single);
                let v = self.v.vector(self.steps, &mut self.w);
                Some((v, &mut self.work))
            }
            // combination of the basis vectors whose preconditioned counterparts were not stored
            Stage::EndOfCycle => {
                let y = self.hessenberg.solve(self.steps);
                self.z.add_combination(&y[..self.stored], self.x);
                (self.stored < self.steps).then(|| {
                    self.v.combine(self.stored, &y[self.stored..], &mut self.w);
                    // The last product decides: there is no further cycle.
                    if !self.progress.may_iterate() {
                        self.v.clear();
                    }
                    (&*self.w, &mut *self.work)
                })
            }
            Stage::TrueResidual | Stage::Done => None,
        }
    }

    /// Continues with the preconditioned vector.
    fn after_preconditioner(&mut self) {
        match self.stage {
            // the residual never grows within a cycle, so the stored vectors are the first ones
            Stage::Step { single } if !(single && self.fixed) => {
                self.z.store(self.steps, &mut self.work);
                self.stored = self.steps + 1;
            }
            Stage::EndOfCycle if self.stored < self.steps => axpy(1.0, &self.work, self.x),
            _ => {}
        }
    }

    /// The next vector to be multiplied and the buffer for the product.
    fn before_product(&mut self) -> Option<(&[f64], &mut [f64])> {
        match self.stage {
            Stage::Step { .. } => Some((&self.work, &mut self.w)),
            Stage::TrueResidual | Stage::EndOfCycle => Some((self.x, &mut self.w)),
            Stage::Done => None,
        }
    }

    /// Continues with the product.
    fn after_product(&mut self) -> Result<(), LinalgError> {
        match self.stage {
            Stage::Step { .. } => self.step(),
            Stage::TrueResidual | Stage::EndOfCycle => self.check_convergence(),
            Stage::Done => Ok(()),
        }
    }

    /// Finishes, or begins a cycle with the true residual.
    fn check_convergence(&mut self) -> Result<(), LinalgError> {
        if let Some(report) = self.progress.check_product(self.b, &mut self.w)? {
            (self.report, self.stage) = (report, Stage::Done);
            return Ok(());
        }
        self.size = self.v.norm(&mut self.w);
        self.hessenberg.start(self.size);
        (self.steps, self.stored) = (0, 0);
        self.continue_from(self.size);
        Ok(())
    }

    /// Finishes an Arnoldi step.
    fn step(&mut self) -> Result<(), LinalgError> {
        let (column, progress) = (self.hessenberg.column(self.steps), &mut self.progress);
        self.size = self.v.orthogonalise(self.steps + 1, &mut self.w, column);
        if !self.size.is_finite() {
            return Err(progress.broken("the operator or the preconditioner returned NaN"));
        }
        let residual = self.hessenberg.rotate(self.steps, self.size);
        self.steps += 1;
        let small = progress.step(residual);
        // an invariant subspace contains the solution, or the operator is singular: the true
        // residual decides
        let invariant = self.size <= f64::EPSILON * self.hessenberg.column_norm(self.steps - 1);
        if small || invariant || self.steps == self.restart || !progress.may_iterate() {
            self.stage = Stage::EndOfCycle;
        } else {
            self.continue_from(residual);
        }
        Ok(())
    }

    /// Continues with a step after a residual of this norm.
    fn continue_from(&mut self, residual: f64) {
        let single = self.progress.single_is_enough(residual);
        self.stage = Stage::Step { single };
    }
}
