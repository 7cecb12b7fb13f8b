//! Integrals as sums over cells, in a fixed order.

use rayon::prelude::*;

use crate::FemError;

/// Items summed as one sequential task. Fixed, so that sums do not depend on the thread count.
const ITEMS_PER_TASK: usize = 1024;

/// Sums of the `N` numbers that `term` gives for each of `0..n`: partial sums over fixed chunks, added in order.
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
