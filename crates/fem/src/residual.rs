//! Residuals of the momentum and the continuity equation.

use std::borrow::Cow;

use linalg::{Csr, Csr3};
use mesh::Vec3;
use rayon::prelude::*;
use sprs::CsMatI;

use crate::error::{FemError, check_array, check_length, check_vectors};

/// Number of rows per task: enough work to outweigh its start.
const ROWS_PER_TASK: usize = 256;

/// Residual of the momentum equation without load, `r = K u + B^T p`.
///
/// For a solution without body force it is zero at the free nodes; at the nodes on a body it is the
/// nodal force that the body exerts on the fluid.
///
/// Shapes: `stiffness` and `divergence` over all nodes, as
/// [`TaylorHood::stiffness`](crate::TaylorHood::stiffness) and
/// [`TaylorHood::divergence`](crate::TaylorHood::divergence) return them; `velocity` and the result
/// `n_points`, `pressure` `n_vertices`.
///
/// # Errors
/// Shapes that do not match; a velocity, pressure or residual that is not finite.
pub fn momentum_residual(
    stiffness: &Csr,
    divergence: &Csr3,
    velocity: &[Vec3],
    pressure: &[f64],
) -> Result<Vec<Vec3>, FemError> {
    let n = stiffness.rows();
    check_length("a row of the stiffness matrix", stiffness.cols(), n)?;
    check_length("a row of the divergence", divergence.cols(), n)?;
    check_vectors("the velocity", velocity, n)?;
    check_array("the pressure", pressure, divergence.rows())?;
    let stiffness = &by_rows(stiffness);

    let mut residual = vec![Vec3::zeros(); n];
    let (starts, columns, values) = (stiffness.indptr(), stiffness.indices(), stiffness.data());
    residual
        .par_iter_mut()
        .enumerate()
        .with_min_len(ROWS_PER_TASK)
        .for_each(|(row, r)| {
            for k in starts.outer_inds_sz(row) {
                *r += values[k] * velocity[columns[k] as usize];
            }
        });
    for (b, (row, column)) in divergence.iter() {
        residual[column as usize] += Vec3::from(*b) * pressure[row as usize];
    }
    check_vectors("the residual", &residual, n)?;
    Ok(residual)
}

/// Residual of the continuity equation, `B u`: minus the divergence tested with each `ψ_q`.
///
/// Shapes: `divergence` over all nodes, as
/// [`TaylorHood::divergence`](crate::TaylorHood::divergence) returns it; `velocity` `n_points`; the
/// result `n_vertices`.
///
/// # Errors
/// A velocity of the wrong length; a velocity or residual that is not finite.
pub fn continuity_residual(divergence: &Csr3, velocity: &[Vec3]) -> Result<Vec<f64>, FemError> {
    check_vectors("the velocity", velocity, divergence.cols())?;
    let divergence = &by_rows(divergence);
    let row = |row: usize| -> f64 {
        let Some(entries) = divergence.outer_view(row) else {
            return 0.0;
        };
        let products = entries
            .iter()
            .map(|(node, b)| Vec3::from(*b).dot(&velocity[node]));
        products.sum()
    };
    let residual: Vec<f64> = (0..divergence.rows()).into_par_iter().map(row).collect();
    check_array("the residual", &residual, divergence.rows())?;
    Ok(residual)
}

/// The same matrix compressed by rows: sprs matrices may also be compressed by columns.
fn by_rows<T: Clone + Default>(matrix: &CsMatI<T, u32, usize>) -> Cow<'_, CsMatI<T, u32, usize>> {
    match matrix.is_csr() {
        true => Cow::Borrowed(matrix),
        false => Cow::Owned(matrix.to_csr()),
    }
}
