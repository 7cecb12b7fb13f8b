//! The kernel on which everything runs: three right-hand sides per pass over a scalar matrix.

use crate::csr::Rows;
use crate::row_blocks::RowBlocks;
use crate::scalar::Scalar;

/// The node rows `[K (x) I3, C]` of a bordered operator.
pub(crate) struct NodeRows<'a, T> {
    pub k: Rows<'a, T>,
    /// Three rows a node, most of them empty.
    pub c: Rows<'a, T>,
    pub blocks: &'a RowBlocks,
}

impl<T: Scalar> NodeRows<'_, T> {
    /// Calls `f(i, a_i, &mut y[i])` for every node `i`, with `a_i = ((K (x) I3) x + C v)_i`.
    ///
    /// Reads every matrix entry once; what a smoother or residual does with `a_i` is fused into `f`.
    pub fn for_each(
        &self,
        x: &[[T; 3]],
        v: &[T],
        y: &mut [[T; 3]],
        f: impl Fn(usize, [T; 3], &mut [T; 3]) + Sync,
    ) {
        let (k, c) = (self.k, self.c);
        self.blocks.for_each(y, &|i, yi| {
            let mut a = [T::default(); 3];
            for (j, kij) in k.row(i) {
                let xj = x[j];
                a[0] += kij * xj[0];
                a[1] += kij * xj[1];
                a[2] += kij * xj[2];
            }
            if c.indptr[3 * i] < c.indptr[3 * i + 3] {
                for d in 0..3 {
                    for (col, value) in c.row(3 * i + d) {
                        a[d] += value * v[col];
                    }
                }
            }
            f(i, a, yi);
        });
    }
}

/// `sum_j a_ij x_j` of one row, accumulated in f64: border rows may have 10^5 entries.
#[inline]
pub(crate) fn long_row<T: Scalar>(a: Rows<'_, T>, i: usize, x: &[T]) -> f64 {
    a.row(i).map(|(j, v)| (v * x[j]).to_f64()).sum()
}
