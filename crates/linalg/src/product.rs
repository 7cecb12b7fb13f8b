//! Products of sparse matrices, built row by row in parallel.

use rayon::prelude::*;

use crate::csr::{Csr, Rows};
use crate::vector::map_rows;

/// Rows per task, enough to make the allocation of three arrays worthwhile.
const ROWS_PER_TASK: usize = 1024;

/// A row under construction: dense values and the list of columns in use.
pub(crate) struct RowAccumulator {
    values: Vec<f64>,
    touched_by: Vec<u32>,
    row: u32,
    columns: Vec<u32>,
}

impl RowAccumulator {
    fn new(cols: usize) -> Self {
        RowAccumulator {
            values: vec![0.0; cols],
            touched_by: vec![0; cols],
            row: 0,
            columns: Vec::new(),
        }
    }

    /// Adds `value` to column `j` of the row.
    #[inline]
    pub fn add(&mut self, j: usize, value: f64) {
        if self.touched_by[j] == self.row {
            self.values[j] += value;
        } else {
            self.touched_by[j] = self.row;
            self.values[j] = value;
            self.columns.push(j as u32);
        }
    }
}

/// The matrix whose row `i` is the sum of the entries that `fill(i, row)` adds.
///
/// Cost: that of `fill` plus sorting each row.
pub(crate) fn build_rows(
    rows: usize,
    cols: usize,
    fill: impl Fn(usize, &mut RowAccumulator) + Sync,
) -> Csr {
    let pieces: Vec<(Vec<usize>, Vec<u32>, Vec<f64>)> = (0..rows.div_ceil(ROWS_PER_TASK))
        .into_par_iter()
        .map_init(
            || RowAccumulator::new(cols),
            |row, task| {
                let range = task * ROWS_PER_TASK..rows.min((task + 1) * ROWS_PER_TASK);
                let mut piece = (Vec::with_capacity(range.len()), Vec::new(), Vec::new());
                for i in range {
                    row.row = i as u32 + 1;
                    row.columns.clear();
                    fill(i, row);
                    row.columns.sort_unstable();
                    piece.0.push(row.columns.len());
                    piece.1.extend_from_slice(&row.columns);
                    piece
                        .2
                        .extend(row.columns.iter().map(|&j| row.values[j as usize]));
                }
                piece
            },
        )
        .collect();
    let mut indptr = Vec::with_capacity(rows + 1);
    indptr.push(0);
    let mut entries = 0;
    for (lengths, ..) in &pieces {
        for length in lengths {
            entries += length;
            indptr.push(entries);
        }
    }
    let mut columns = Vec::with_capacity(entries);
    let mut values = Vec::with_capacity(entries);
    for (_, c, v) in pieces {
        columns.extend_from_slice(&c);
        values.extend_from_slice(&v);
    }
    Csr::new((rows, cols), indptr, columns, values)
}

/// `A B`.
pub(crate) fn multiply(a: &Csr, b: &Csr) -> Csr {
    let (left, right) = (Rows::new(a), Rows::new(b));
    build_rows(a.rows(), b.cols(), |i, row| {
        for (k, aik) in left.row(i) {
            for (j, bkj) in right.row(k) {
                row.add(j, aik * bkj);
            }
        }
    })
}

/// `(A (x) I3) X + Y` for `X` and `Y` with three interleaved rows per node.
///
/// Borders are empty at most nodes: the columns of `A` are examined once per node, and skipped if
/// all rows of `X` that they select are empty.
pub(crate) fn kron3_multiply_add(a: &Csr, x: &Csr, y: &Csr) -> Csr {
    let (a_rows, x_rows, y_rows) = (Rows::new(a), Rows::new(x), Rows::new(y));
    let starts = x_rows.indptr;
    let filled = map_rows(a.cols(), &|k| starts[3 * k] < starts[3 * k + 3]);
    let meets = |i: usize| a_rows.entries(i).0.iter().any(|&k| filled[k as usize]);
    let met = map_rows(a.rows(), &meets);
    build_rows(3 * a.rows(), x.cols(), |i, row| {
        for (c, v) in y_rows.row(i) {
            row.add(c, v);
        }
        let (node, d) = (i / 3, i % 3);
        if met[node] {
            for (k, aik) in a_rows.row(node).filter(|&(k, _)| filled[k]) {
                for (c, v) in x_rows.row(3 * k + d) {
                    row.add(c, aik * v);
                }
            }
        }
    })
}
