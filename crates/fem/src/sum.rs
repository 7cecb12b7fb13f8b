//! Sums over cells in a fixed order, so that they do not depend on the number of threads.

use rayon::prelude::*;

use crate::FemError;
use crate::quantity::Quantity;

/// Number of terms per task, fixed, so that sums do not depend on the number of threads.
const ITEMS_PER_TASK: usize = 1024;

/// Number of cells whose results are stored at the same time, to bound the memory.
const CELLS_PER_BATCH: usize = 1 << 12;

/// Number of cells per task: enough work to outweigh its start.
pub(crate) const CELLS_PER_TASK: usize = 256;

/// Sum of `term(i)` over `0..n`.
///
/// Partial sums over chunks of fixed length are computed in parallel and added in order.
pub(crate) fn sum_over<T: Quantity>(
    n: usize,
    term: impl Fn(usize) -> Result<T, FemError> + Sync,
) -> Result<T, FemError> {
    let add = |mut sum: T, part: T| {
        sum.add_scaled(1.0, &part);
        sum
    };
    let parts: Vec<Result<T, FemError>> = (0..n.div_ceil(ITEMS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let first = task * ITEMS_PER_TASK;
            (first..n.min(first + ITEMS_PER_TASK))
                .try_fold(T::zero(), |sum, item| Ok(add(sum, term(item)?)))
        })
        .collect();
    parts
        .into_iter()
        .try_fold(T::zero(), |sum, part| Ok(add(sum, part?)))
}

/// Computes a result for each of `n` cells or facets in parallel and adds the results in order.
pub(crate) fn accumulate_items<T: Send>(
    n: usize,
    compute: impl Fn(usize) -> Result<T, FemError> + Sync,
    mut add: impl FnMut(usize, T) + Send,
) -> Result<(), FemError> {
    let mut outcome = Ok(());
    let write = |item: usize, result: &mut Option<_>| *result = Some(compute(item));
    accumulate(n, write, |item, result| match result.take() {
        Some(Ok(result)) if outcome.is_ok() => add(item, result),
        Some(Err(error)) if outcome.is_ok() => outcome = Err(error),
        _ => {}
    });
    outcome
}

/// [`accumulate_items`] for results that are no errors and are written over earlier ones.
///
/// While the results of one batch are added, those of the next one are computed.
pub(crate) fn accumulate<T: Default + Send>(
    n: usize,
    compute: impl Fn(usize, &mut T) + Sync,
    mut add: impl FnMut(usize, &mut T) + Send,
) {
    let cells_from = |first: usize| first..n.min(first + CELLS_PER_BATCH);
    let compute_batch = |first: usize, results: &mut [T]| {
        let numbered = cells_from(first).into_par_iter().zip(results);
        numbered
            .with_min_len(CELLS_PER_TASK)
            .for_each(|(cell, result)| compute(cell, result));
    };
    let empty = || (0..n.min(CELLS_PER_BATCH)).map(|_| T::default()).collect();
    let (mut results, mut next): (Vec<T>, Vec<T>) = (empty(), empty());
    compute_batch(0, &mut results);
    for first in (0..n).step_by(CELLS_PER_BATCH) {
        let add_batch = || {
            let numbered = cells_from(first).zip(&mut results);
            numbered.for_each(|(cell, result)| add(cell, result));
        };
        let following = first + CELLS_PER_BATCH;
        rayon::join(add_batch, || {
            if following < n {
                compute_batch(following, &mut next);
            }
        });
        std::mem::swap(&mut results, &mut next);
    }
}
