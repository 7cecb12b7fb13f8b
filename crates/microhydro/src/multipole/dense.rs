//! Mobility by one factorisation of the whole matrix, for few multipoles per sphere.
//!
//! Iterations consist of many small products per pair of spheres and run at a twentieth of the
//! speed of one large factorisation. The factorisation also gives both orders at once, and its cost
//! does not depend on the condition number, which narrow gaps make large.

use super::Scaled;
use super::elimination::eliminate;
use super::modes::Family;
use super::system::System;
use crate::HydroError;

/// Scaled mobility matrices for the orders of a system and two orders lower.
///
/// Cost: `n^3/3` operations and `n^2` numbers for `n` degrees of freedom.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
pub(super) fn mobility(system: &System) -> Result<Scaled, HydroError> {
    let (places, kept) = places(system);
    let rigid = 6 * system.spheres;
    let [full, lower] = eliminate(system.dense(&places), rigid, kept)?;
    Ok(Scaled { full, lower })
}

/// Row of each mode in the order of elimination, and the number of rows of the lower order.
///
/// Modes of the lower order come first, then the others, then the rigid motions.
fn places(system: &System) -> (Vec<Vec<usize>>, usize) {
    let lower = system.mask(|modes, family, l| modes.in_lower_order(family, l));
    let is_rigid = |family: Family, l: usize| l == 1 && family != Family::Source;
    let rigid = system.mask(|_, family, l| is_rigid(family, l));
    // the container has no rigid motion to keep
    let stays = |body: usize, row: usize| body < system.spheres && rigid[body][row];
    let mut places: Vec<Vec<usize>> = lower.iter().map(|mask| vec![0; mask.len()]).collect();
    let mut next = 0..;
    let mut kept = 0;
    for (pass, wanted) in [true, false].into_iter().enumerate() {
        for (body, rows) in places.iter_mut().enumerate() {
            for (row, place) in rows.iter_mut().enumerate() {
                if lower[body][row] == wanted && !stays(body, row) {
                    *place = next.next().unwrap_or_default();
                }
            }
        }
        if pass == 0 {
            kept = next.start;
        }
    }
    for (sphere, rows) in places.iter_mut().enumerate().take(system.spheres) {
        for row in system.rigid_rows(sphere) {
            rows[row] = next.next().unwrap_or_default();
        }
    }
    (places, kept)
}
