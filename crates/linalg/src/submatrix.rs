//! Extraction of rows and columns of a sparse matrix.

use rayon::prelude::*;
use sprs::CsMatI;

use crate::LinalgError;
use crate::csr::{Rows, check_shape};

/// Number of a column that [`submatrix`] leaves out.
pub const OMITTED: u32 = u32::MAX;

/// Number of rows per task: enough work to outweigh the start of a task.
const ROWS_PER_TASK: usize = 4096;

/// The given rows of a matrix, in the given order, restricted to numbered columns.
///
/// Column `j` of `matrix` becomes column `numbers[j]` of the result, or is left out where this is
/// [`OMITTED`]. Different columns must have different numbers below `n_columns`.
///
/// Cost: two passes over the rows, in parallel. The same for any number of threads.
///
/// ```
/// use linalg::{Csr, OMITTED, submatrix};
/// // [1 2; 3 4]: the second row, and the first column of it.
/// let matrix = Csr::new((2, 2), vec![0, 2, 4], vec![0, 1, 0, 1], vec![1.0, 2.0, 3.0, 4.0]);
/// let block = submatrix(&matrix, &[1], &[0, OMITTED], 1)?;
/// assert_eq!(block, Csr::new((1, 1), vec![0, 1], vec![0], vec![3.0]));
/// # Ok::<(), linalg::LinalgError>(())
/// ```
///
/// # Errors
/// [`LinalgError::Shape`] if the matrix is not stored by rows or has another number of columns than
/// there are `numbers`; [`LinalgError::Index`] for a row that does not exist, a number that is not
/// below `n_columns`, and one that two columns have.
pub fn submatrix<T: Copy + Default + Send + Sync>(
    matrix: &CsMatI<T, u32, usize>,
    rows: &[u32],
    numbers: &[u32],
    n_columns: usize,
) -> Result<CsMatI<T, u32, usize>, LinalgError> {
    if !matrix.is_csr() {
        let (expected, found) = (matrix.shape(), (matrix.cols(), matrix.rows()));
        let what = "matrix, which must be stored by rows,";
        return Err(LinalgError::Shape {
            what,
            expected,
            found,
        });
    }
    check_shape(
        "list of column numbers",
        (numbers.len(), 1),
        (matrix.cols(), 1),
    )?;
    let index = |what, index: u32, len| Err(LinalgError::Index { what, index, len });
    if let Some(&row) = rows.iter().find(|&&row| row as usize >= matrix.rows()) {
        return index("row of the matrix", row, matrix.rows());
    }
    check_numbers(numbers, n_columns)?;
    let from = Rows::new(matrix);
    let is_kept = |column: &&u32| numbers[**column as usize] != OMITTED;
    let lengths: Vec<usize> = rows
        .par_iter()
        .map(|&row| from.entries(row as usize).0.iter().filter(is_kept).count())
        .collect();
    let mut starts = Vec::with_capacity(rows.len() + 1);
    starts.push(0);
    let mut end = 0;
    for length in lengths {
        end += length;
        starts.push(end);
    }
    let (mut indices, mut values) = (vec![0; end], vec![T::default(); end]);
    let (mut later_indices, mut later_values) = (&mut indices[..], &mut values[..]);
    let mut tasks = Vec::with_capacity(rows.len().div_ceil(ROWS_PER_TASK));
    for (task, rows) in rows.chunks(ROWS_PER_TASK).enumerate() {
        let first = task * ROWS_PER_TASK;
        let length = starts[first + rows.len()] - starts[first];
        let (indices, others) = later_indices.split_at_mut(length);
        later_indices = others;
        let (values, others) = later_values.split_at_mut(length);
        later_values = others;
        tasks.push((rows, indices, values));
    }
    tasks
        .into_par_iter()
        .for_each_init(Vec::new, |sorted, (rows, indices, values)| {
            let mut position = 0;
            for &row in rows {
                sort_row(from.entries(row as usize).0, numbers, sorted);
                let old_values = from.entries(row as usize).1;
                for &word in sorted.iter() {
                    indices[position] = (word >> 32) as u32;
                    values[position] = old_values[word as u32 as usize];
                    position += 1;
                }
            }
        });
    Ok(CsMatI::new(
        (rows.len(), n_columns),
        starts,
        indices,
        values,
    ))
}

/// Writes the numbers of the columns that are not left out to `sorted`, ascending, each in the
/// upper half of a word with its position in the row in the lower half.
///
/// A word sorts several times faster than a column with its value.
fn sort_row(columns: &[u32], numbers: &[u32], sorted: &mut Vec<u64>) {
    sorted.clear();
    for (position, &column) in columns.iter().enumerate() {
        let number = numbers[column as usize];
        if number != OMITTED {
            sorted.push(u64::from(number) << 32 | position as u64);
        }
    }
    sorted.sort_unstable();
}

/// Refuses numbers that are not below `n_columns`, and numbers that occur twice.
fn check_numbers(numbers: &[u32], n_columns: usize) -> Result<(), LinalgError> {
    let kept = numbers.iter().copied().filter(|&number| number != OMITTED);
    let mut kept: Vec<u32> = kept.collect();
    kept.sort_unstable();
    let refused = |what, index| {
        let len = n_columns;
        Err(LinalgError::Index { what, index, len })
    };
    if n_columns > OMITTED as usize {
        return refused("number of columns, which must fit into u32,", OMITTED);
    }
    if let Some(&largest) = kept
        .last()
        .filter(|&&largest| largest as usize >= n_columns)
    {
        return refused("number of a column", largest);
    }
    match kept.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => refused("number of two columns", pair[0]),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Csr;

    /// Rows 2 and 0 of three, columns 2 and 1 with the numbers 0 and 1.
    #[test]
    fn columns_are_renumbered_and_sorted() {
        let matrix = Csr::new(
            (3, 3),
            vec![0, 3, 4, 6],
            vec![0, 1, 2, 0, 1, 2],
            vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0],
        );
        let found = submatrix(&matrix, &[2, 0], &[OMITTED, 1, 0], 2).expect("sound");
        let expected = Csr::new(
            (2, 2),
            vec![0, 2, 4],
            vec![0, 1, 0, 1],
            vec![6.0, 5.0, 3.0, 2.0],
        );
        assert_eq!(found, expected);
    }

    /// A tridiagonal matrix with reversed numbers, over several tasks: each entry tells its origin.
    #[test]
    fn large_matrices_are_split_into_tasks() {
        let n = 2 * ROWS_PER_TASK + 100;
        let band = |i: usize| i.saturating_sub(1)..(i + 2).min(n);
        let mut starts = vec![0];
        (0..n).for_each(|i| starts.push(starts[i] + band(i).len()));
        let columns = (0..n).flat_map(band).map(|j| j as u32).collect();
        let values = (0..n)
            .flat_map(|i| band(i).map(move |j| (i * n + j) as f64))
            .collect();
        let matrix = Csr::new((n, n), starts, columns, values);
        let reversed: Vec<u32> = (0..n as u32).rev().collect();
        let found = submatrix(&matrix, &reversed, &reversed, n).expect("sound");
        for (i, row) in found.outer_iterator().enumerate() {
            let old = n - 1 - i;
            let expected = band(old).rev().map(|j| (n - 1 - j, (old * n + j) as f64));
            assert!(row.iter().map(|(j, &v)| (j, v)).eq(expected), "row {i}");
        }
    }
}
