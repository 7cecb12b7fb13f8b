//! The transpose of a compressed-row matrix, in parallel.

use std::ops::Range;

use rayon::prelude::*;
use sprs::CsMatI;

use crate::LinalgError;
use crate::csr::{Csr, Rows, check_shape};
use crate::product::build_rows;

/// Tasks that gather rows of the transpose.
///
/// Enough to balance the work, few enough to keep the searches in every row cheap.
const GATHER_TASKS: usize = 8;

/// Nonzeros per row and task above which several tasks are worth their searches.
const MIN_ENTRIES_PER_SEARCH: usize = 4;

/// The transpose of a matrix, both stored by rows.
///
/// Each task owns a range of rows of the transpose, which is an interval of columns in every row of
/// `matrix`, found by bisection. Cost: two passes over `matrix`, two bisections per row and task.
/// The result does not depend on the number of tasks.
pub(crate) fn transpose<V: Copy + Default + Send + Sync>(
    matrix: &CsMatI<V, u32, usize>,
) -> CsMatI<V, u32, usize> {
    let (from, cols) = (Rows::new(matrix), matrix.cols());
    let searched = MIN_ENTRIES_PER_SEARCH * GATHER_TASKS * matrix.rows();
    let tasks = if from.nnz() < searched {
        1
    } else {
        GATHER_TASKS
    };
    let ranges: Vec<Range<usize>> = (0..tasks)
        .map(|task| task * cols / tasks..(task + 1) * cols / tasks)
        .collect();
    let counts: Vec<Vec<usize>> = ranges
        .par_iter()
        .map(|range| {
            let mut counts = vec![0; range.len()];
            visit(from, range, |_, column, _| counts[column] += 1);
            counts
        })
        .collect();
    let mut starts = Vec::with_capacity(cols + 1);
    starts.push(0);
    let mut end = 0;
    for count in counts.into_iter().flatten() {
        end += count;
        starts.push(end);
    }
    let mut columns = vec![0; end];
    let mut values = vec![V::default(); end];
    let mut places = Vec::with_capacity(tasks);
    let (mut later_columns, mut later_values) = (&mut columns[..], &mut values[..]);
    for range in ranges {
        let own = starts[range.end] - starts[range.start];
        let (columns, others) = later_columns.split_at_mut(own);
        later_columns = others;
        let (values, others) = later_values.split_at_mut(own);
        later_values = others;
        places.push((range, columns, values));
    }
    places.into_par_iter().for_each(|(range, columns, values)| {
        let first = starts[range.start];
        let mut next: Vec<usize> = starts[range.clone()].iter().map(|s| s - first).collect();
        visit(from, &range, |row, column, value| {
            let place = &mut next[column];
            columns[*place] = row;
            values[*place] = value;
            *place += 1;
        });
    });
    CsMatI::new((cols, matrix.rows()), starts, columns, values)
}

/// The symmetric part `(A + A^T) / 2`.
///
/// # Errors
/// [`LinalgError::Shape`] for a matrix that is not square.
pub(crate) fn symmetric_part(matrix: &Csr) -> Result<Csr, LinalgError> {
    let size = (matrix.rows(), matrix.rows());
    check_shape("matrix of a symmetric part", matrix.shape(), size)?;
    let transposed = transpose(matrix);
    let (a, at) = (Rows::new(matrix), Rows::new(&transposed));
    Ok(build_rows(matrix.rows(), matrix.cols(), |i, row| {
        for (j, value) in a.row(i).chain(at.row(i)) {
            row.add(j, 0.5 * value);
        }
    }))
}

/// Calls `take(row, column - range.start, value)` for all entries with columns in `range`, row by
/// row.
#[inline(always)]
fn visit<V: Copy>(matrix: Rows<'_, V>, range: &Range<usize>, mut take: impl FnMut(u32, usize, V)) {
    for row in 0..matrix.indptr.len() - 1 {
        let (columns, values) = matrix.entries(row);
        let first = columns.partition_point(|&column| (column as usize) < range.start);
        for (&column, &value) in columns[first..].iter().zip(&values[first..]) {
            if column as usize >= range.end {
                break;
            }
            take(row as u32, column as usize - range.start, value);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Few and many nonzeros per row, with one task and with several.
        #[test]
        fn every_entry_changes_row_and_column(
            cols in 1..90usize,
            lengths in proptest::collection::vec(0..90usize, 0..12),
        ) {
            let rows: Vec<Vec<u32>> = lengths
                .iter()
                .enumerate()
                .map(|(i, &length)| {
                    let mut columns: Vec<u32> = (0..length)
                        .map(|k| ((7 * i + 31 * k) % cols) as u32)
                        .collect();
                    columns.sort_unstable();
                    columns.dedup();
                    columns
                })
                .collect();
            let mut starts = vec![0];
            rows.iter().for_each(|row| starts.push(starts[starts.len() - 1] + row.len()));
            let columns = rows.concat();
            let values = (0..columns.len()).map(|k| k as f64 + 1.0).collect();
            let matrix = Csr::new((rows.len(), cols), starts, columns, values);
            prop_assert_eq!(transpose(&matrix), matrix.transpose_view().to_csr());
        }
    }
}
