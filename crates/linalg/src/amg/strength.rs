//! Strong connections between nodes.

use crate::Csr;
use crate::csr::Rows;
use crate::product::build_rows;

/// The off-diagonal entries with `a_ij^2 > threshold^2 a_ii a_jj`, with their values.
pub(super) fn symmetric(k: &Csr, diagonal: &[f64], threshold: f64) -> Csr {
    let rows = Rows::of(k);
    let limit = threshold * threshold;
    build_rows(k.rows(), k.cols(), |i, row| {
        for (j, a) in rows.row(i) {
            if j != i && a * a > limit * diagonal[i] * diagonal[j] {
                row.add(j, a);
            }
        }
    })
}
