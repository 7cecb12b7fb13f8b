//! Extension of prescribed boundary displacements to the free vertices.

use std::iter::Sum;
use std::ops::Mul;

use fem::DirichletCondition;
use linalg::{Csr, KrylovParams, LinearOperator, Preconditioner, cg};
use mesh::Vec3;
use rayon::prelude::*;

use crate::AleError;

/// Relative residual to which extensions are solved.
///
/// An extension need not be accurate, only smooth: any field with the correct boundary values is a
/// valid mesh motion. With 1e-8 its error is below the rounding of the f32 coordinates in pictures,
/// at the cost of a few iterations.
const RESIDUAL_TOLERANCE: f64 = 1e-8;

/// Number of rows per task.
const ROWS_PER_TASK: usize = 512;

/// Solves `A d = 0` at the free vertices, with the prescribed values of each field.
///
/// `apply` is the product with `A` over all vertices, `operator` its block of the free vertices.
/// Returns the number of iterations of all solves.
pub(crate) fn extend(
    condition: &DirichletCondition,
    apply: &dyn Fn(&[Vec3]) -> Vec<Vec3>,
    operator: &dyn LinearOperator,
    preconditioner: &mut dyn Preconditioner,
    params: &KrylovParams,
    fields: &mut [Vec<Vec3>],
) -> Result<usize, AleError> {
    let mut iterations = 0;
    for field in fields {
        condition.lift(field)?;
        let mut rhs = condition.restrict(&apply(field))?;
        rhs.iter_mut().for_each(|value| *value = -*value);
        let mut solution = vec![0.0; rhs.len()];
        iterations += cg(operator, preconditioner, &rhs, &mut solution, params)?.iterations;
        condition.expand(&solution, field)?;
    }
    Ok(iterations)
}

/// Parameters of the solver with a limit on the number of iterations.
pub(crate) fn krylov(max_iterations: usize) -> KrylovParams {
    KrylovParams::default()
        .with_rel_tol(RESIDUAL_TOLERANCE)
        .with_max_iterations(max_iterations)
}

/// Product `K d` of a scalar matrix and a vector field.
pub(crate) fn scalar_product(matrix: &Csr, d: &[Vec3]) -> Vec<Vec3> {
    let mut image = vec![Vec3::zeros(); matrix.rows()];
    product(matrix, d, &mut image);
    image
}

/// Product `y = A x` for numbers, or vectors with each component multiplied by `A`.
///
/// Rows are summed in the order of their columns: bitwise the same for any number of threads.
pub(crate) fn product<T>(matrix: &Csr, x: &[T], y: &mut [T])
where
    T: Copy + Send + Sync + Sum,
    f64: Mul<T, Output = T>,
{
    y.par_iter_mut()
        .with_min_len(ROWS_PER_TASK)
        .enumerate()
        .for_each(|(row, sum)| {
            if let Some(row) = matrix.outer_view(row) {
                *sum = row.iter().map(|(column, &value)| value * x[column]).sum();
            }
        });
}
