//! Blocks of rows with about equal work, processed in parallel.

use std::ops::Range;

use crate::columns::split_mut;

/// Nonzeros per block: about 10 microseconds of work, far above the cost of a fork.
const BLOCK_ENTRIES: usize = 1 << 14;

/// Boundaries of row blocks with about equal numbers of nonzeros.
///
/// Each row is computed by one thread in a fixed order, so results never depend on the blocks.
#[derive(Debug, Clone)]
pub(crate) struct RowBlocks(Vec<usize>);

impl RowBlocks {
    /// Divides the rows of `indptr`; an empty row counts as one nonzero.
    pub fn new(indptr: &[usize]) -> Self {
        let rows = indptr.len() - 1;
        let mut bounds = vec![0];
        let mut last = 0;
        for i in 1..=rows {
            if indptr[i] + i - last >= BLOCK_ENTRIES {
                bounds.push(i);
                last = indptr[i] + i;
            }
        }
        if bounds.last() != Some(&rows) || bounds.len() == 1 {
            bounds.push(rows);
        }
        RowBlocks(bounds)
    }

    /// Calls `f(i, &mut y[i])` for every row.
    pub fn for_each<T: Send>(&self, y: &mut [T], f: &(impl Fn(usize, &mut T) + Sync)) {
        self.for_each_block([y], &|rows, [y]| {
            for (i, y) in rows.zip(y) {
                f(i, y);
            }
        });
    }

    /// Calls `f(rows, y[rows])` for every block of rows, with all columns of `y`.
    pub fn for_each_block<T: Send, const S: usize>(
        &self,
        y: [&mut [T]; S],
        f: &(impl Fn(Range<usize>, [&mut [T]; S]) + Sync),
    ) {
        split(&self.0, y, f);
    }
}

fn split<T: Send, const S: usize>(
    bounds: &[usize],
    y: [&mut [T]; S],
    f: &(impl Fn(Range<usize>, [&mut [T]; S]) + Sync),
) {
    if bounds.len() == 2 {
        return f(bounds[0]..bounds[1], y);
    }
    let middle = bounds.len() / 2;
    let (low, high) = split_mut(y, bounds[middle] - bounds[0]);
    rayon::join(
        || split(&bounds[..=middle], low, f),
        || split(&bounds[middle..], high, f),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_visited_once() {
        for rows in [0, 1, 5, 20_000, 100_000] {
            let indptr: Vec<usize> = (0..=rows).map(|i| 3 * i).collect();
            let mut y = vec![0usize; rows];
            RowBlocks::new(&indptr).for_each(&mut y, &|i, y| *y += i + 1);
            assert!(y.iter().enumerate().all(|(i, &y)| y == i + 1));
        }
    }
}
