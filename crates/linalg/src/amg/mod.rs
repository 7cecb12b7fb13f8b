//! Smoothed aggregation for a scalar matrix with a border, one step per file.
//!
//! The steps are strength -> aggregate -> tentative -> smooth, after Vanek, Mandel, Brezina
//! (Computing 56, 1996); the division into steps follows PyAMG. The near-null space is the
//! constants; border dofs are not aggregated.

mod aggregate;
mod smooth;
mod strength;
mod tentative;

pub use aggregate::Aggregates;

use crate::chebyshev::JacobiScaling;
use crate::{Bordered, Prolongation};

/// Prolongation from the next coarser level, or `None` if aggregation no longer coarsens.
///
/// `diagonal` is that of `K` and `threshold` that of strong connections.
pub(crate) fn prolongation(
    fine: &Bordered,
    diagonal: &[f64],
    scaling: &JacobiScaling,
    threshold: f64,
) -> Option<Prolongation> {
    let strong = strength::symmetric(fine.stiffness(), diagonal, threshold);
    // nodes that are constrained in different components must not be aggregated
    let constrained = fine.constrained_dofs().bits(fine.nodes());
    let aggregates = aggregate::standard(&strong, &constrained);
    let tentative = tentative::constant(&aggregates);
    // coarsening by less than a fifth of the dofs costs more than factorising the finer level
    if tentative.cols() == 0 || 5 * tentative.cols() > 4 * fine.nodes() {
        return None;
    }
    Some(smooth::jacobi(fine, scaling, &tentative, &constrained))
}
