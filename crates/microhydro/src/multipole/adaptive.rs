//! Resistance to a requested accuracy: raises the order until the error estimate is small enough.

use super::accuracy::Accuracy;
use super::fixed_order::{self, FIXED_ORDER_TOLERANCE};
use super::lubrication;
use super::order::{self, Orders};
use crate::{HydroError, Medium, Resistance, Spheres};

/// Lowest target relative to the tolerance.
///
/// If the estimate is still above the tolerance at this target, rounding errors dominate it.
const MIN_TARGET_RATIO: f64 = 1e-4;

/// Grand resistance matrix of spheres to a given accuracy.
///
/// Forces and torques (about the centres) that the spheres exert on the fluid for their velocities
/// and angular velocities: six rows and columns per sphere, translation, then rotation. Viscosity
/// 1: multiply by the viscosity.
///
/// Cost: spheres on one axis (through the container's centre, or along the wall's normal) take 0.1
/// ms for three spheres with gaps of four radii. Other arrangements take `n^3/3` operations for `n`
/// multipoles in all; large ones are solved by iteration, with `O(L^3)` operations per pair, rigid
/// motion and iteration for the order `L`. Off an axis, the orders are bounded, and narrow gaps are
/// corrected by the exact two-sphere resistance (Durlofsky, Brady & Bossis 1987).
///
/// # Errors
/// Spheres outside the medium; gaps so narrow that the accuracy is out of reach; failed solves.
pub fn resistance(
    spheres: &Spheres,
    medium: &Medium,
    accuracy: &Accuracy,
) -> Result<Resistance, HydroError> {
    spheres.check_inside(medium)?;
    let xi = order::gap_coordinates(spheres, medium);
    if let Some(order) = accuracy.order {
        let orders = Orders::all(spheres.len(), medium, order);
        return fixed_order::resistance(spheres, medium, &xi, &orders, FIXED_ORDER_TOLERANCE);
    }
    // Below this tolerance rounding errors dominate.
    let tolerance = accuracy.tolerance.max(1e-13);
    let mut target = order::first_target(&xi, spheres.len(), tolerance);
    let mut orders = order::for_tolerance(&xi, medium, target);
    loop {
        let (result, corrected) = lubrication::with_pair_corrections(
            spheres,
            medium,
            &xi,
            &orders,
            target.min(tolerance),
        )?;
        let estimate = result.relative_error();
        let final_order = target <= tolerance && corrected;
        if final_order || estimate <= tolerance || target < MIN_TARGET_RATIO * tolerance {
            return Ok(result);
        }
        target *= (0.5 * tolerance / estimate).clamp(0.01, 0.5);
        // The lowest orders suffice for targets far below the one that selected them. The same
        // orders would give the same estimate, so the target is lowered until the orders rise.
        let mut raised = order::for_tolerance(&xi, medium, target);
        while raised == orders && target > f64::MIN_POSITIVE {
            target *= 0.1;
            raised = order::for_tolerance(&xi, medium, target);
        }
        orders = raised;
    }
}
