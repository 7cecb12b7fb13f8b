//! Flexible GMRES with restarts, for one or several right-hand sides.

use super::basis::{Orthonormal, RoundedBasis};
use super::hessenberg::Hessenberg;
use super::progress::Progress;
use super::report::{KrylovParams, SolveReport, check_start};
use crate::csr::check_shape;
use crate::vector::axpy;
use crate::{LinalgError, LinearOperator, Preconditioner, PreconditionerKind};

const METHOD: &str = "FGMRES";

/// Solves `A x = b` by right-preconditioned flexible GMRES, starting from `x`.
///
/// Stops when the *true* `||b - A x|| / ||b||` is at most `rel_tol`: it is recomputed when the recurrence says so, and the
/// iteration goes on if it is not. Where the operator has [weights](LinearOperator::residual_weights) the method minimises the residual in their
/// norm (Essai, Numer. Algorithms 18, 1998), and twice that, an estimate of the error, must fall below `rel_tol` too. A zero `b` gives a zero `x`.
///
/// Memory: 12 bytes an unknown and iteration, taken as needed, and 4 once the residual is so small that f32 leaves the result alone: the error
/// of a basis vector enters multiplied with the residual of its step, so precision may fall as the residual does (van den Eshof,
/// Sleijpen, SIAM J. Matrix Anal. Appl. 26, 2004). From there on only the vectors before the preconditioner are kept, where it is linear, and what they
/// add to the solution is preconditioned once at the end. Reference: Saad, SIAM J. Sci. Comput. 14 (1993).
///
/// # Errors
/// [`LinalgError::NotConverged`], [`LinalgError::Stagnated`] (both with the best iterate left in `x`), [`LinalgError::Breakdown`] for NaN,
/// [`LinalgError::Shape`], [`LinalgError::NotFinite`], [`LinalgError::Parameter`].
///
/// ```
/// use linalg::{Bordered, Csr, Identity, KrylovParams, fgmres};
/// let k = Csr::new((2, 2), vec![0, 2, 4], vec![0, 1, 0, 1], vec![2.0, -1.0, -1.0, 2.0]);
/// let a = Bordered::scalar(k)?;
/// let mut x = [0.0; 6];
/// let report = fgmres(&a, &mut Identity(6), &[1.0, 2.0, 3.0, 1.0, 2.0, 3.0], &mut x, &KrylovParams::default())?;
/// assert!(report.true_rel_residual <= 1e-8); // the right-hand side is an eigenvector of eigenvalue 1
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
    let mut column = Column::new(operator, preconditioner, b, x, params)?;
    iterate(operator, preconditioner, std::slice::from_mut(&mut column))?;
    Ok(column.report)
}

/// Solves `A x = b` for several right-hand sides, each as [`fgmres`] does, to the last bit: the same iterations, tolerance and report.
///
/// Only the passes over the matrices are shared: each iteration takes one through the preconditioner and one through the operator
/// for all right-hand sides that have not converged yet ([`LinearOperator::apply_columns`], [`Preconditioner::apply_columns`]).
/// Memory: that of [`fgmres`] for each right-hand side at the same time.
///
/// # Errors
/// Those of [`fgmres`], as soon as one right-hand side fails; [`LinalgError::Shape`] when there are not as many solutions as right-hand sides.
///
/// ```
/// use linalg::{Bordered, Csr, Identity, KrylovParams, fgmres_columns};
/// let k = Csr::new((2, 2), vec![0, 2, 4], vec![0, 1, 0, 1], vec![2.0, -1.0, -1.0, 2.0]);
/// let a = Bordered::scalar(k)?;
/// let (mut x, mut y) = ([0.0; 6], [0.0; 6]);
/// let b: [&[f64]; 2] = [&[1.0, 2.0, 3.0, 1.0, 2.0, 3.0], &[3.0, 0.0, 0.0, -3.0, 0.0, 0.0]];
/// let reports = fgmres_columns(&a, &mut Identity(6), &b, &mut [&mut x, &mut y], &KrylovParams::default())?;
/// assert!((x[5] - 3.0).abs() < 1e-7 && (y[3] + 1.0).abs() < 1e-7); // eigenvectors of eigenvalues 1 and 3
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
    let mut columns = Vec::with_capacity(b.len());
    for (b, x) in b.iter().zip(x) {
        columns.push(Column::new(operator, preconditioner, b, x, params)?);
    }
    iterate(operator, preconditioner, &mut columns)?;
    Ok(columns.into_iter().map(|column| column.report).collect())
}

/// Runs all columns to their ends, a pass through the preconditioner and one through the operator at a time.
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

/// What a column does with the next product.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// It is the product with the solution: a look at the true residual, after which a cycle begins.
    Look,
    /// It is that of the basis vector of an Arnoldi step, which is to be kept in f32 if `single`.
    Step { single: bool },
    /// As `Look`, but first the cycle that ends is added to the solution.
    EndOfCycle,
    /// There is none.
    Done,
}

/// One right-hand side on its way.
struct Column<'a> {
    b: &'a [f64],
    x: &'a mut [f64],
    progress: Progress<'a>,
    restart: usize,
    /// Whether the preconditioner is a fixed linear map.
    fixed: bool,
    v: Orthonormal<'a>,
    z: RoundedBasis,
    hessenberg: Hessenberg,
    w: Vec<f64>,
    work: Vec<f64>,
    stage: Stage,
    /// Norm of `w` where it is the next basis vector.
    size: f64,
    /// Steps of the cycle, and how many of them keep their preconditioned vectors.
    steps: usize,
    stored: usize,
    /// How it went, once it is done.
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
            Some(_) => Stage::Look,
            None => Stage::Done,
        };
        let restart = params.restart.min(params.max_iterations).max(1);
        let n = b.len();
        Ok(Column {
            progress: Progress::new(METHOD, operator, params, b),
            restart,
            fixed: preconditioner.kind() <= PreconditionerKind::Linear,
            v: Orthonormal::new(operator.residual_weights()),
            z: RoundedBasis::new(),
            hessenberg: Hessenberg::new(restart),
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
        })
    }

    /// The next vector to be preconditioned and where it goes.
    fn before_preconditioner(&mut self) -> Option<(&[f64], &mut [f64])> {
        match self.stage {
            Stage::Step { single } => {
                self.v.store(self.steps, &self.w, self.size, single);
                let v = self.v.vector(self.steps, &mut self.w);
                Some((v, &mut self.work))
            }
            // what vectors of the cycle whose preconditioned ones were not kept add to the solution
            Stage::EndOfCycle => {
                let y = self.hessenberg.solve(self.steps);
                self.z.add_combination(&y[..self.stored], self.x);
                (self.stored < self.steps).then(|| {
                    self.v.combine(self.stored, &y[self.stored..], &mut self.w);
                    (&*self.w, &mut *self.work)
                })
            }
            Stage::Look | Stage::Done => None,
        }
    }

    /// Takes the preconditioned vector.
    fn after_preconditioner(&mut self) {
        match self.stage {
            // the residual never grows, so that the vectors kept are the first ones
            Stage::Step { single } if !(single && self.fixed) => {
                self.z.store(self.steps, &mut self.work);
                self.stored = self.steps + 1;
            }
            Stage::EndOfCycle if self.stored < self.steps => axpy(1.0, &self.work, self.x),
            _ => {}
        }
    }

    /// The next vector to be multiplied and where its product goes.
    fn before_product(&mut self) -> Option<(&[f64], &mut [f64])> {
        match self.stage {
            Stage::Step { .. } => Some((&self.work, &mut self.w)),
            Stage::Look | Stage::EndOfCycle => Some((self.x, &mut self.w)),
            Stage::Done => None,
        }
    }

    /// Takes the product.
    fn after_product(&mut self) -> Result<(), LinalgError> {
        match self.stage {
            Stage::Step { .. } => self.step(),
            Stage::Look | Stage::EndOfCycle => self.look(),
            Stage::Done => Ok(()),
        }
    }

    /// Ends, or begins a cycle with the true residual.
    fn look(&mut self) -> Result<(), LinalgError> {
        if let Some(report) = self.progress.judge(self.b, &mut self.w)? {
            (self.report, self.stage) = (report, Stage::Done);
            return Ok(());
        }
        self.size = self.v.norm(&mut self.w);
        self.hessenberg.start(self.size);
        (self.steps, self.stored) = (0, 0);
        self.continue_from(self.size);
        Ok(())
    }

    /// Ends an Arnoldi step.
    fn step(&mut self) -> Result<(), LinalgError> {
        let (column, progress) = (self.hessenberg.column(self.steps), &mut self.progress);
        self.size = self.v.orthogonalise(self.steps + 1, &mut self.w, column);
        if !self.size.is_finite() {
            return Err(progress.broken("the operator or the preconditioner returned NaN"));
        }
        let residual = self.hessenberg.rotate(self.steps, self.size);
        self.steps += 1;
        let small = progress.step(residual);
        // an invariant subspace holds the solution, or the operator is singular: the true residual tells
        let invariant = self.size <= f64::EPSILON * self.hessenberg.column_norm(self.steps - 1);
        if small || invariant || self.steps == self.restart || !progress.may_iterate() {
            tracing::debug!(iterations = progress.iterations, "{METHOD} cycle");
            self.stage = Stage::EndOfCycle;
        } else {
            self.continue_from(residual);
        }
        Ok(())
    }

    /// A step follows, after a residual of this norm.
    fn continue_from(&mut self, residual: f64) {
        let single = self.progress.single_is_enough(residual);
        self.stage = Stage::Step { single };
    }
}
