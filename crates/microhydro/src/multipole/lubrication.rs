//! Narrow gaps off an axis: exact pair resistances added to expansions of bounded order.
//!
//! ```text
//! R = R_L + sum over pairs (R² - R²_L)
//! ```
//! after Durlofsky, Brady & Bossis (1987), where `R_L` is the resistance of all spheres at order
//! `L`, `R²` the exact resistance of the pair alone and `R²_L` that of the pair at order `L`. A
//! pair is collinear, so a high order computes `R²` for all gaps of practical interest, instead of
//! the asymptotic series of Jeffrey & Onishi (1984). A sphere close to the container or the wall is
//! treated in the same way.

use super::order::{self, Orders};
use super::{at_orders, frame};
use crate::{HydroError, Medium, Resistance, Spheres};

/// Highest order off an axis. It suffices without corrections for gaps of 0.05 at a tolerance of
/// 1e-4 and of 0.15 at 1e-8.
pub const MOST_IN_SPACE: usize = 28;

/// Highest order of the container off an axis.
pub(super) const MOST_ON_CONTAINER: usize = 2 * MOST_IN_SPACE;

/// Highest number of multipoles with `m = 1` on an axis; their elimination takes about a second.
const MOST_COLLINEAR: usize = 3000;

/// Relative uncertainty of a pair correction, because other spheres change the flow in the gap.
///
/// Three spheres around a gap of 0.02 showed a sixth of it: errors of 1.8e-4 where the correction
/// was 0.1.
const CHANGED_BY_OTHERS: f64 = 0.01;

/// Resistance with bounded orders and pair corrections, and whether there were corrections.
///
/// Corrections are added for the pairs whose gaps need more than the highest order.
pub(super) fn completed(
    spheres: &Spheres,
    medium: &Medium,
    closeness: &(Vec<f64>, f64),
    orders: &Orders,
    tolerance: f64,
) -> Result<(Resistance, bool), HydroError> {
    if frame::Frame::of(spheres, medium).collinear {
        check_collinear(spheres, medium, orders, tolerance)?;
        let result = at_orders(spheres, medium, closeness, orders, tolerance)?;
        return Ok((result, false));
    }
    let cut = orders.cut(MOST_IN_SPACE, MOST_ON_CONTAINER);
    let mut result = at_orders(spheres, medium, closeness, &cut, tolerance)?;
    if cut == *orders {
        return Ok((result, false));
    }
    for second in 0..spheres.len() {
        for first in 0..second {
            complete(
                &mut result,
                spheres,
                &[first, second],
                &Medium::Unbounded,
                &cut,
                tolerance,
            )?;
        }
        if *medium != Medium::Unbounded {
            complete(&mut result, spheres, &[second], medium, &cut, tolerance)?;
        }
    }
    Ok((result, true))
}

/// Adds the correction of a pair (or of one sphere and the boundary), if its gap needs one.
fn complete(
    result: &mut Resistance,
    spheres: &Spheres,
    group: &[usize],
    medium: &Medium,
    cut: &Orders,
    tolerance: f64,
) -> Result<(), HydroError> {
    let alone = Spheres::new(
        group.iter().map(|&k| spheres.centres()[k]).collect(),
        group.iter().map(|&k| spheres.radii()[k]).collect(),
    )?;
    let closeness = order::closeness(&alone, medium);
    let needed = order::for_tolerance(&closeness, medium, tolerance);
    let used = Orders {
        spheres: group.iter().map(|&k| cut.spheres[k]).collect(),
        container: cut.container,
    };
    let suffices = needed.container <= used.container
        && needed
            .spheres
            .iter()
            .zip(&used.spheres)
            .all(|(n, u)| n <= u);
    if suffices {
        return Ok(());
    }
    // Collinear expansions are cheap: a lower tolerance makes the error of the pair negligible.
    let needed = order::for_tolerance(&closeness, medium, 0.01 * tolerance);
    check_collinear(&alone, medium, &needed, tolerance)?;
    let exact = at_orders(&alone, medium, &closeness, &needed, tolerance)?;
    let missed = at_orders(&alone, medium, &closeness, &used, tolerance)?;
    let rows: Vec<usize> = group.iter().flat_map(|&k| 6 * k..6 * k + 6).collect();
    let correction = exact.matrix() - missed.matrix();
    let uncertain = &correction * (CHANGED_BY_OTHERS / result.tail());
    result.add(
        &rows,
        &correction,
        &(exact.matrix() - missed.coarser() - uncertain),
    );
    Ok(())
}

fn check_collinear(
    spheres: &Spheres,
    medium: &Medium,
    orders: &Orders,
    tolerance: f64,
) -> Result<(), HydroError> {
    let unknowns: usize = 3 * (orders.spheres.iter().sum::<usize>() + orders.container);
    if unknowns <= MOST_COLLINEAR {
        return Ok(());
    }
    let (surfaces, gap) = spheres.narrowest_gap(medium);
    let bodies = spheres.len() + usize::from(matches!(medium, Medium::Ball { .. }));
    Err(HydroError::TooClose {
        surfaces,
        gap,
        tolerance,
        needed: orders
            .spheres
            .iter()
            .copied()
            .fold(orders.container, usize::max),
        most: MOST_COLLINEAR / 3 / bodies,
    })
}
