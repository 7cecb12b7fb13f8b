//! Smoothed aggregation for a scalar matrix with a border, one step a file.
//!
//! strength -> aggregate -> tentative -> smooth, after Vanek, Mandel, Brezina (Computing 56, 1996); the split
//! follows PyAMG. The near-null space is the constant; border unknowns pass through un-aggregated.

mod aggregate;
mod smooth;
mod strength;
mod tentative;

use crate::{Bordered, Prolongation};

/// Prolongation to the next coarser level, or `None` when aggregation no longer coarsens.
///
/// `upper` bounds the spectrum of `D^-1 K`, `threshold` is that of the strength of connection.
pub(crate) fn prolongation(
    fine: &Bordered,
    diagonal: &[f64],
    upper: f64,
    threshold: f64,
) -> Option<Prolongation> {
    let strong = strength::symmetric(fine.stiffness(), diagonal, threshold);
    // nodes that are held in different components must not be moved together
    let constrained = fine.constrained_dofs().bits(fine.nodes());
    let aggregates = aggregate::standard(&strong, &constrained);
    let tentative = tentative::constant(&aggregates);
    // less than a fifth fewer unknowns a level: cheaper to factorise here than to go on
    if tentative.cols() == 0 || 5 * tentative.cols() > 4 * fine.nodes() {
        return None;
    }
    Some(smooth::jacobi(
        fine,
        diagonal,
        upper,
        &tentative,
        &constrained,
    ))
}
