//! Mobility by one factorisation of the whole matrix, for few multipoles per sphere.
//!
//! Iterations consist of many small products per pair of spheres and run at a twentieth of the
//! speed of one large factorisation. The factorisation also gives both orders at once, and its cost
//! does not depend on the condition number, which narrow gaps make large.

use nalgebra::DMatrix;

use super::elimination::{complements, eliminate};
use super::modes::Family;
use super::scaled::ScaledMobility;
use super::system::System;
use crate::HydroError;

/// Scaled mobility matrices for the orders of a system and two orders lower.
///
/// Cost: `n^3/3` operations and `n^2` numbers for `n` degrees of freedom.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
pub(super) fn mobility(system: &System) -> Result<ScaledMobility, HydroError> {
    let (elimination_rows, lower_size) = elimination_rows(system);
    let rigid = 6 * system.spheres;
    let [full, lower] = eliminate(system.dense(&elimination_rows), rigid, lower_size)?;
    Ok(ScaledMobility { full, lower })
}

/// Scaled mobility matrix for the orders of a system alone.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
pub(super) fn full_mobility(system: &System) -> Result<DMatrix<f64>, HydroError> {
    let (elimination_rows, _) = elimination_rows(system);
    let [full] = complements(system.dense(&elimination_rows), [6 * system.spheres])?;
    Ok(full)
}

/// Row of each mode in the order of elimination, and the number of rows of the lower order.
///
/// Modes of the lower order come first, then the others, then the rigid motions.
fn elimination_rows(system: &System) -> (Vec<Vec<usize>>, usize) {
    let lower = system.mask(|modes, family, l| modes.in_lower_order(family, l));
    let is_rigid = |family: Family, l: usize| l == 1 && family != Family::Source;
    let rigid = system.mask(|_, family, l| is_rigid(family, l));
    // the container has no rigid motion to keep
    let stays = |expansion: usize, row: usize| expansion < system.spheres && rigid[expansion][row];
    let mut elimination_rows: Vec<Vec<usize>> =
        lower.iter().map(|mask| vec![0; mask.len()]).collect();
    let mut next = 0..;
    let mut lower_size = 0;
    for (pass, wanted) in [true, false].into_iter().enumerate() {
        for (expansion, rows) in elimination_rows.iter_mut().enumerate() {
            for (row, place) in rows.iter_mut().enumerate() {
                if lower[expansion][row] == wanted && !stays(expansion, row) {
                    *place = next.next().unwrap_or_default();
                }
            }
        }
        if pass == 0 {
            lower_size = next.start;
        }
    }
    for (sphere, rows) in elimination_rows.iter_mut().enumerate().take(system.spheres) {
        for row in system.rigid_rows(sphere) {
            rows[row] = next.next().unwrap_or_default();
        }
    }
    (elimination_rows, lower_size)
}
