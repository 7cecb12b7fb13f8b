//! Sums over cells in a fixed order, so that they do not depend on the number of threads.

use mesh::TetMesh;
use rayon::prelude::*;

use crate::FemError;

/// Number of terms per task, fixed, so that sums do not depend on the number of threads.
const ITEMS_PER_TASK: usize = 1024;

/// Number of cells whose results are stored at the same time, to bound the memory.
const CELLS_PER_BATCH: usize = 1 << 14;

/// Number of cells per task: enough work to outweigh its start.
pub(crate) const CELLS_PER_TASK: usize = 256;

/// Sum of `term(i)`, an array of `N` numbers, over `0..n`.
///
/// Partial sums over chunks of fixed length are computed in parallel and added in order.
pub(crate) fn sum_over<const N: usize>(
    n: usize,
    term: impl Fn(usize) -> Result<[f64; N], FemError> + Sync,
) -> Result<[f64; N], FemError> {
    let add = |mut sum: [f64; N], part: [f64; N]| {
        for k in 0..N {
            sum[k] += part[k];
        }
        sum
    };
    let parts: Vec<Result<[f64; N], FemError>> = (0..n.div_ceil(ITEMS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let first = task * ITEMS_PER_TASK;
            (first..n.min(first + ITEMS_PER_TASK))
                .try_fold([0.0; N], |sum, item| Ok(add(sum, term(item)?)))
        })
        .collect();
    parts
        .into_iter()
        .try_fold([0.0; N], |sum, part| Ok(add(sum, part?)))
}

/// Computes a result for every cell in parallel and adds the results in the order of the cells.
pub(crate) fn accumulate_cells<T: Send>(
    mesh: &TetMesh,
    compute: impl Fn(usize) -> Result<T, FemError> + Sync,
    mut add: impl FnMut(usize, T),
) -> Result<(), FemError> {
    let mut outcome = Ok(());
    accumulate(mesh, compute, |cell, result| match result {
        Ok(result) if outcome.is_ok() => add(cell, result),
        Err(error) if outcome.is_ok() => outcome = Err(error),
        _ => {}
    });
    outcome
}

/// [`accumulate_cells`] for results that are no errors.
pub(crate) fn accumulate<T: Send>(
    mesh: &TetMesh,
    compute: impl Fn(usize) -> T + Sync,
    mut add: impl FnMut(usize, T),
) {
    let mut results = Vec::new();
    for first in (0..mesh.n_cells()).step_by(CELLS_PER_BATCH) {
        let last = mesh.n_cells().min(first + CELLS_PER_BATCH);
        (first..last)
            .into_par_iter()
            .with_min_len(CELLS_PER_TASK)
            .map(&compute)
            .collect_into_vec(&mut results);
        for (cell, result) in (first..last).zip(results.drain(..)) {
            add(cell, result);
        }
    }
}
