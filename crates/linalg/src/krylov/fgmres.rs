//! Flexible GMRES with restarts.

use super::basis::{Orthonormal, RoundedBasis};
use super::progress::Progress;
use super::report::{KrylovParams, SolveReport, check_start};
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
    let Some(_) = check_start(operator, preconditioner, b, x, params)? else {
        return Ok(SolveReport::zero(x));
    };
    let n = b.len();
    let restart = params.restart.min(params.max_iterations).max(1);
    let mut progress = Progress::new(METHOD, operator, params, b);
    let mut v = Orthonormal::new(operator.residual_weights());
    let mut z = RoundedBasis::new();
    let (mut w, mut work) = (vec![0.0; n], vec![0.0; n]);
    let mut hessenberg = Hessenberg::new(restart);
    let fixed = preconditioner.kind() <= PreconditionerKind::Linear;
    loop {
        if let Some(report) = progress.look(operator, b, x, &mut w)? {
            return Ok(report);
        }
        let mut residual = v.norm(&mut w);
        hessenberg.start(residual);
        let (mut size, mut steps, mut stored) = (residual, 0, 0);
        while steps < restart && progress.may_iterate() {
            let single = progress.single_is_enough(residual);
            v.store(steps, &w, size, single);
            preconditioner.apply(v.vector(steps, &mut w), &mut work);
            // the residual never grows, so that the vectors kept are the first ones
            if !(single && fixed) {
                z.store(steps, &mut work);
                stored = steps + 1;
            }
            operator.apply(&work, &mut w);
            size = v.orthogonalise(steps + 1, &mut w, hessenberg.column(steps));
            if !size.is_finite() {
                return Err(progress.broken("the operator or the preconditioner returned NaN"));
            }
            residual = hessenberg.rotate(steps, size);
            steps += 1;
            let small = progress.step(residual);
            // an invariant subspace holds the solution, or the operator is singular: the true residual tells
            if small || size <= f64::EPSILON * hessenberg.column_norm(steps - 1) {
                break;
            }
        }
        tracing::debug!(iterations = progress.iterations, "{METHOD} cycle");
        let y = hessenberg.solve(steps);
        z.add_combination(&y[..stored], x);
        if stored < steps {
            v.combine(stored, &y[stored..], &mut w);
            preconditioner.apply(&w, &mut work);
            axpy(1.0, &work, x);
        }
    }
}

/// The least-squares problem `min ||beta e1 - H y||`, kept triangular by Givens rotations.
struct Hessenberg {
    columns: Vec<Vec<f64>>,
    rotations: Vec<(f64, f64)>,
    rhs: Vec<f64>,
    y: Vec<f64>,
}

impl Hessenberg {
    fn new(restart: usize) -> Self {
        Hessenberg {
            columns: (0..restart).map(|j| vec![0.0; j + 2]).collect(),
            rotations: vec![(1.0, 0.0); restart],
            rhs: vec![0.0; restart + 1],
            y: vec![0.0; restart],
        }
    }

    fn start(&mut self, beta: f64) {
        self.rhs.fill(0.0);
        self.rhs[0] = beta;
    }

    /// Column `j`, whose first `j + 1` entries are for the caller to fill.
    fn column(&mut self, j: usize) -> &mut [f64] {
        &mut self.columns[j]
    }

    /// Norm of column `j`, which rotations leave as it was.
    fn column_norm(&self, j: usize) -> f64 {
        self.columns[j].iter().map(|h| h * h).sum::<f64>().sqrt()
    }

    /// Ends column `j` with `below` under the diagonal; returns the residual norm.
    fn rotate(&mut self, j: usize, below: f64) -> f64 {
        let column = &mut self.columns[j];
        for (i, &(c, s)) in self.rotations[..j].iter().enumerate() {
            let (a, b) = (column[i], column[i + 1]);
            column[i] = c * a + s * b;
            column[i + 1] = c * b - s * a;
        }
        let diagonal = column[j];
        let r = diagonal.hypot(below);
        let (c, s) = if r > 0.0 {
            (diagonal / r, below / r)
        } else {
            (1.0, 0.0)
        };
        column[j] = r;
        column[j + 1] = 0.0;
        self.rotations[j] = (c, s);
        self.rhs[j + 1] = -s * self.rhs[j];
        self.rhs[j] *= c;
        self.rhs[j + 1].abs()
    }

    /// The coefficients of the first `steps` vectors; a singular last pivot gets none.
    fn solve(&mut self, steps: usize) -> &[f64] {
        for i in (0..steps).rev() {
            let known: f64 = (i + 1..steps).map(|j| self.columns[j][i] * self.y[j]).sum();
            let pivot = self.columns[i][i];
            self.y[i] = if pivot.abs() > f64::EPSILON * self.column_norm(i) {
                (self.rhs[i] - known) / pivot
            } else {
                0.0
            };
        }
        &self.y[..steps]
    }
}
