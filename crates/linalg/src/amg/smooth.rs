//! One damped Jacobi step on the tentative prolongation, including border columns.

use crate::chebyshev::JacobiScaling;
use crate::csr::Rows;
use crate::product::build_rows;
use crate::{Bordered, Csr, Prolongation};

/// The smoothed prolongation `P = (I - w D^-1 K) T`, with border columns `Q = -w D^-1 C`.
///
/// Likewise `Q_l = -w D^-1 C_l` if there is a left border. `D` is the diagonal matrix of `scaling`;
/// the factor `w = 4 / (3 upper)` minimises the bound on the energy.
///
/// The border columns result from the same Jacobi step on the tentative prolongation `[T 0; 0 I]`
/// of the bordered operator: a border dof moves the nodes around it.
///
/// A node interpolates only from aggregates that are constrained in every component in which the
/// node is constrained (bits of `constrained`). The weights of all other aggregates are added to
/// the weight of the node's own aggregate, so that constants are still interpolated exactly (a
/// filtered matrix, as for weak connections in Vanek, Mandel, Brezina 1996).
pub(super) fn jacobi(
    fine: &Bordered,
    scaling: &JacobiScaling,
    tentative: &Csr,
    constrained: &[u8],
) -> Prolongation {
    let JacobiScaling { diagonal, upper } = scaling;
    let omega = 4.0 / (3.0 * upper);
    let (k, t) = (Rows::of(fine.stiffness()), Rows::of(tentative));
    let nodes = build_rows(fine.nodes(), tentative.cols(), |i, row| {
        for (aggregate, value) in t.row(i) {
            row.add(aggregate, value);
        }
        for (j, kij) in k.row(i) {
            let source = if constrained[i] & !constrained[j] == 0 {
                j
            } else {
                i
            };
            for (aggregate, value) in t.row(source) {
                row.add(aggregate, -omega / diagonal[i] * kij * value);
            }
        }
    });
    let smoothed_border = |border: &Csr| {
        let c = Rows::of(border);
        build_rows(3 * fine.nodes(), fine.border_len(), |i, row| {
            for (col, value) in c.row(i) {
                row.add(col, -omega / diagonal[i / 3] * value);
            }
        })
    };
    Prolongation::from_parts(
        nodes,
        smoothed_border(fine.border()),
        fine.border_left().map(smoothed_border),
    )
}
