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

use super::fixed_order;
use super::frame::Frame;
use super::order::{self, GapCoordinates, MAX_ORDER_OFF_AXIS, MAX_ORDER_ON_CONTAINER, Orders};
use crate::{HydroError, Medium, Resistance, Spheres};

/// Highest number of multipoles with `m = 1` on an axis; their elimination takes about a second.
const MAX_COLLINEAR_DOFS: usize = 3000;

/// Relative uncertainty of a pair correction, because other spheres change the flow in the gap.
///
/// Measured with three spheres around a gap of 0.02: a sixth of this value (an error of 1.8e-4
/// where the correction was 0.1).
const PAIR_UNCERTAINTY: f64 = 0.01;

/// Resistance with bounded orders and pair corrections, and whether there were corrections.
///
/// Corrections are added for the pairs whose gaps need more than the highest order.
pub(super) fn with_pair_corrections(
    spheres: &Spheres,
    medium: &Medium,
    xi: &GapCoordinates,
    orders: &Orders,
    tolerance: f64,
) -> Result<(Resistance, bool), HydroError> {
    if Frame::of(spheres, medium).collinear {
        check_collinear(spheres, medium, orders, tolerance)?;
        let result = fixed_order::resistance(spheres, medium, xi, orders, tolerance)?;
        return Ok((result, false));
    }
    let limited = orders.limited(MAX_ORDER_OFF_AXIS, MAX_ORDER_ON_CONTAINER);
    let mut result = fixed_order::resistance(spheres, medium, xi, &limited, tolerance)?;
    if limited == *orders {
        return Ok((result, false));
    }
    for second in 0..spheres.len() {
        for first in 0..second {
            add_pair_correction(
                &mut result,
                spheres,
                &[first, second],
                &Medium::Unbounded,
                &limited,
                tolerance,
            )?;
        }
        if *medium != Medium::Unbounded {
            add_pair_correction(&mut result, spheres, &[second], medium, &limited, tolerance)?;
        }
    }
    Ok((result, true))
}

/// Adds the correction of a pair (or of one sphere and the boundary), if its gap needs one.
fn add_pair_correction(
    result: &mut Resistance,
    spheres: &Spheres,
    group: &[usize],
    medium: &Medium,
    limited: &Orders,
    tolerance: f64,
) -> Result<(), HydroError> {
    let group_alone = Spheres::new(
        group.iter().map(|&k| spheres.centres()[k]).collect(),
        group.iter().map(|&k| spheres.radii()[k]).collect(),
    )?;
    let xi = order::gap_coordinates(&group_alone, medium);
    let needed = order::for_tolerance(&xi, medium, tolerance);
    let used = Orders {
        spheres: group.iter().map(|&k| limited.spheres[k]).collect(),
        container: limited.container,
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
    let needed = order::for_tolerance(&xi, medium, 0.01 * tolerance);
    check_collinear(&group_alone, medium, &needed, tolerance)?;
    let converged = fixed_order::resistance(&group_alone, medium, &xi, &needed, tolerance)?;
    let bounded = fixed_order::resistance(&group_alone, medium, &xi, &used, tolerance)?;
    let rows: Vec<usize> = group.iter().flat_map(|&k| 6 * k..6 * k + 6).collect();
    let correction = converged.matrix() - bounded.matrix();
    let uncertainty = &correction * (PAIR_UNCERTAINTY / result.tail());
    result.add(
        &rows,
        &correction,
        &(converged.matrix() - bounded.coarser() - uncertainty),
    );
    Ok(())
}

/// Checks that the factorisation of collinear expansions is affordable.
fn check_collinear(
    spheres: &Spheres,
    medium: &Medium,
    orders: &Orders,
    tolerance: f64,
) -> Result<(), HydroError> {
    let dofs: usize = 3 * (orders.spheres.iter().sum::<usize>() + orders.container);
    if dofs <= MAX_COLLINEAR_DOFS {
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
        highest: MAX_COLLINEAR_DOFS / 3 / bodies,
    })
}
