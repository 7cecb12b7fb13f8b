//! Krylov methods on the complement of a null space.

use super::null_vectors::{NullVectors, project_out};
use super::progress::Progress;
use super::report::{KrylovParams, SolveReport, check_start, check_symmetric};
use crate::csr::{check_finite, check_shape};
use crate::vector::norm;
use crate::{LinalgError, LinearOperator, Preconditioner, PreconditionerKind};

/// Fraction of a right-hand side below which its projection counts as rounding error.
const PROJECTION_ROUNDING: f64 = 1e-14;

/// A preconditioner `N` between projections: `z = P_right N P_left r`.
///
/// Without the projections a preconditioner of a singular matrix returns a large multiple of a null
/// vector, whose rounding error would dominate the useful part of `z`.
struct Projected<'a> {
    preconditioner: &'a mut dyn Preconditioner,
    null_vectors: &'a NullVectors,
    projected: Vec<Vec<f64>>,
}

impl Preconditioner for Projected<'_> {
    fn size(&self) -> usize {
        self.preconditioner.size()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.apply_columns(&[r], &mut [z]);
    }

    fn apply_columns(&mut self, r: &[&[f64]], z: &mut [&mut [f64]]) {
        if self.projected.len() < r.len() {
            self.projected.resize(r.len(), Vec::new());
        }
        for (r, projected) in r.iter().zip(&mut self.projected) {
            projected.clear();
            projected.extend_from_slice(r);
            project_out(self.null_vectors.left(), projected);
        }
        let columns: Vec<&[f64]> = self.projected.iter().map(Vec::as_slice).collect();
        self.preconditioner.apply_columns(&columns[..r.len()], z);
        for z in z {
            project_out(self.null_vectors.right(), z);
        }
    }

    fn kind(&self) -> PreconditionerKind {
        self.preconditioner.kind()
    }
}

/// Runs `method` on the complement of the null space of `params`; without one, on the whole space.
pub(super) fn solve(
    operator: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    b: &[&[f64]],
    x: &mut [&mut [f64]],
    params: &KrylovParams,
    method: impl FnOnce(
        &mut dyn Preconditioner,
        &[&[f64]],
        &mut [&mut [f64]],
    ) -> Result<Vec<SolveReport>, LinalgError>,
) -> Result<Vec<SolveReport>, LinalgError> {
    let Some(null_vectors) = params.null_vectors.as_deref() else {
        return method(preconditioner, b, x);
    };
    if operator.sum_over_processes().is_some() {
        return Err(LinalgError::SeveralProcesses {
            method: "a method with null vectors",
        });
    }
    null_vectors.check(operator)?;
    let mut projected = Vec::with_capacity(b.len());
    let mut removed = Vec::with_capacity(b.len());
    for b in b {
        check_shape("right-hand side", (b.len(), 1), (operator.rows(), 1))?;
        check_finite("right-hand side", b)?;
        let before = norm(b);
        let mut rest = b.to_vec();
        project_out(null_vectors.left(), &mut rest);
        if norm(&rest) <= PROJECTION_ROUNDING * before {
            rest.fill(0.0);
        }
        let difference: Vec<f64> = b.iter().zip(&rest).map(|(b, rest)| b - rest).collect();
        removed.push(if before > 0.0 {
            norm(&difference) / before
        } else {
            0.0
        });
        projected.push(rest);
    }
    for x in x.iter_mut() {
        check_shape("solution vector", (x.len(), 1), (operator.cols(), 1))?;
        check_finite("initial guess", x)?;
        project_out(null_vectors.right(), x);
    }
    let mut preconditioner = Projected {
        preconditioner,
        null_vectors,
        projected: Vec::new(),
    };
    let b: Vec<&[f64]> = projected.iter().map(Vec::as_slice).collect();
    let mut reports = method(&mut preconditioner, &b, x)?;
    for (report, removed) in reports.iter_mut().zip(removed) {
        report.rhs_removed = removed;
    }
    // basis vectors in f32 reintroduce null vectors at the level of rounding
    for x in x {
        project_out(null_vectors.right(), x);
    }
    Ok(reports)
}

/// As [`solve`], for a method with one right-hand side, an operator that must be symmetric and a
/// preconditioner that must be symmetric positive definite.
pub(super) fn solve_symmetric(
    name: &'static str,
    operator: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    b: &[f64],
    x: &mut [f64],
    params: &KrylovParams,
    iterate: impl FnOnce(
        &dyn LinearOperator,
        &mut dyn Preconditioner,
        &[f64],
        &mut [f64],
        Progress,
    ) -> Result<SolveReport, LinalgError>,
) -> Result<SolveReport, LinalgError> {
    let method = |preconditioner: &mut dyn Preconditioner, b: &[&[f64]], x: &mut [&mut [f64]]| {
        let (b, x) = (b[0], &mut *x[0]);
        check_symmetric(name, operator, preconditioner)?;
        Ok(vec![
            match check_start(operator, preconditioner, b, x, params)? {
                None => SolveReport::zero(x),
                Some(b_norm) => {
                    let progress = Progress::unweighted(name, params, b_norm);
                    iterate(operator, preconditioner, b, x, progress)?
                }
            },
        ])
    };
    let mut reports = solve(operator, preconditioner, &[b], &mut [x], params, method)?;
    Ok(reports.remove(0))
}
