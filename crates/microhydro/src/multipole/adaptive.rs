//! Resistance to a requested accuracy: raises the orders until the error estimate is small enough.

use super::accuracy::{Accuracy, LOWEST_TOLERANCE};
use super::fixed_order::{self, FIXED_ORDER_TOLERANCE, Reached};
use super::frame::Frame;
use super::order::{self, GapCoordinates, Targets};
use super::orders::Orders;
use crate::{HydroError, Medium, Resistance, Spheres};

/// Grand resistance matrix of spheres to a given accuracy.
///
/// Forces and torques (about the centres) that the spheres exert on the fluid for their velocities
/// and angular velocities: six rows and columns per sphere, translation, then rotation. Viscosity
/// 1: multiply by the viscosity.
///
/// Cost: spheres on one axis (through the container's centre, or along the wall's normal) take 0.1
/// ms for three spheres with gaps of four radii. Other arrangements take `n^3/3` operations for `n`
/// multipoles in all; large ones are solved by iteration, with `O(L^3)` operations per pair, rigid
/// motion and iteration for the order `L`. Off an axis, the high degrees that a narrow gap needs
/// are eliminated for its two surfaces alone.
///
/// # Errors
/// A tolerance that is not between `1e-13` and 1; spheres outside the medium; gaps so narrow that
/// the accuracy is out of reach ([`HydroError::TooClose`], [`HydroError::ToleranceNotReached`]):
/// [`resistance_best`] has an answer for them; failed solves.
pub fn resistance(
    spheres: &Spheres,
    medium: &Medium,
    accuracy: &Accuracy,
) -> Result<Resistance, HydroError> {
    with_accuracy(spheres, medium, accuracy, OutOfReach::Refuse)
}

/// [`resistance`], or the most accurate one at the highest allowed orders.
///
/// [`Resistance::relative_error`] has the estimate, which may be above the tolerance.
///
/// # Errors
/// As [`resistance`], without [`HydroError::TooClose`] and [`HydroError::ToleranceNotReached`].
pub fn resistance_best(
    spheres: &Spheres,
    medium: &Medium,
    accuracy: &Accuracy,
) -> Result<Resistance, HydroError> {
    with_accuracy(spheres, medium, accuracy, OutOfReach::TakeBest)
}

fn with_accuracy(
    spheres: &Spheres,
    medium: &Medium,
    accuracy: &Accuracy,
    out_of_reach: OutOfReach,
) -> Result<Resistance, HydroError> {
    match accuracy.order {
        Some(order) => {
            let orders = Orders::all(spheres.len(), medium, order);
            resistance_at(spheres, medium, &orders)
        }
        None => {
            let lowest = Orders::all(spheres.len(), medium, 0);
            adaptive(spheres, medium, accuracy.tolerance, &lowest, out_of_reach)
        }
    }
}

/// Resistance from expansions of fixed orders: a smooth function of the positions.
///
/// Unlike [`resistance`] it does not raise the orders: [`Resistance::relative_error`] is the
/// estimate for these orders and positions.
///
/// # Errors
/// [`HydroError::Length`] for orders of another number of spheres; spheres outside the medium;
/// failed solves.
pub fn resistance_at(
    spheres: &Spheres,
    medium: &Medium,
    orders: &Orders,
) -> Result<Resistance, HydroError> {
    if orders.spheres.len() != spheres.len() {
        return Err(HydroError::Length {
            what: "orders of the spheres",
            expected: spheres.len(),
            found: orders.spheres.len(),
        });
    }
    spheres.check_inside(medium)?;
    let orders = orders.at_least(&Orders::all(spheres.len(), medium, 0));
    Ok(fixed_order::resistance(spheres, medium, &orders, FIXED_ORDER_TOLERANCE)?.resistance)
}

/// Orders at which [`resistance_at`] meets a tolerance in each of several configurations.
///
/// Each configuration starts with the orders of those before it. See [`Orders`] for an example.
/// Configurations with the narrowest gaps of a motion give orders that suffice for all of it.
///
/// # Errors
/// [`HydroError::Length`] for configurations of different numbers of spheres; otherwise as
/// [`resistance`].
pub fn orders_for(
    configurations: &[Spheres],
    medium: &Medium,
    tolerance: f64,
) -> Result<Orders, HydroError> {
    let spheres = configurations.first().map_or(0, Spheres::len);
    let mut orders = Orders::all(spheres, medium, 0);
    orders.off_axis = configurations.iter().any(|one| !Frame::of(one, medium).collinear);
    for configuration in configurations {
        if configuration.len() != spheres {
            return Err(HydroError::Length {
                what: "spheres of a configuration",
                expected: spheres,
                found: configuration.len(),
            });
        }
        let found = adaptive(configuration, medium, tolerance, &orders, OutOfReach::Refuse)?;
        orders = orders.at_least(found.orders());
    }
    Ok(orders)
}

/// What to do where the tolerance is out of reach.
#[derive(Clone, Copy, PartialEq, Eq)]
enum OutOfReach {
    Refuse,
    TakeBest,
}

/// Lowest targets relative to the tolerance.
///
/// If the estimate is still above the tolerance at these targets, rounding errors dominate it.
const MIN_TARGET_RATIO: f64 = 1e-6;

/// Resistance to a tolerance from orders of at least `lowest`.
fn adaptive(
    spheres: &Spheres,
    medium: &Medium,
    tolerance: f64,
    lowest: &Orders,
    out_of_reach: OutOfReach,
) -> Result<Resistance, HydroError> {
    // The comparison also rejects NaN.
    if !(LOWEST_TOLERANCE..=1.0).contains(&tolerance) {
        return Err(HydroError::BadTolerance {
            tolerance,
            lowest: LOWEST_TOLERANCE,
        });
    }
    spheres.check_inside(medium)?;
    let n = spheres.len();
    let on_axis = Frame::of(spheres, medium).collinear && !lowest.off_axis;
    let gaps = order::gaps(spheres, medium);
    let xi = GapCoordinates::narrowest_of(&gaps, n);
    let needed =
        |targets: Targets| order::for_targets(&gaps, n, medium, targets).at_least(lowest);
    let mut targets = Targets {
        expansions: order::first_target(&xi.widened(), n, tolerance),
        gaps: order::first_target(&xi, n, tolerance),
    };
    let first = needed(targets);
    let mut orders = first.affordable(on_axis);
    let (surfaces, gap) = spheres.narrowest_gap(medium);
    if orders != first && out_of_reach == OutOfReach::Refuse {
        return Err(HydroError::TooClose {
            surfaces,
            gap,
            tolerance,
            needed: first.highest(),
            highest: orders.highest(),
        });
    }
    let mut best: Option<Resistance> = None;
    loop {
        let accuracy = targets.expansions.min(tolerance);
        let Reached {
            resistance,
            expansions,
            gaps: in_gaps,
        } = fixed_order::resistance(spheres, medium, &orders, accuracy)?;
        let reached = resistance.relative_error();
        if reached <= tolerance {
            return Ok(resistance);
        }
        if best.as_ref().is_none_or(|best| reached < best.relative_error()) {
            best = Some(resistance);
        }
        // on an axis the expansions resolve the gaps themselves
        let in_gaps = if on_axis { expansions } else { in_gaps };
        // The lowest orders suffice for targets far below the one that selected them. The same
        // orders would give the same estimate, so the targets are lowered until the orders rise.
        let mut raised = orders.clone();
        let mut factor = 1.0;
        while raised == orders && factor > MIN_TARGET_RATIO {
            let lower = |target: f64, part: f64| match part > 0.4 * tolerance {
                true => target * factor * (0.4 * tolerance / part).clamp(0.01, 0.5),
                false => target,
            };
            let lowered = Targets {
                expansions: lower(targets.expansions, expansions),
                gaps: lower(targets.gaps, in_gaps),
            };
            raised = needed(lowered).affordable(on_axis);
            if raised != orders {
                targets = lowered;
            }
            factor *= 0.1;
        }
        let exhausted = targets.expansions.min(targets.gaps) < MIN_TARGET_RATIO * tolerance;
        if raised != orders && !exhausted {
            orders = raised;
            continue;
        }
        return match (out_of_reach, best) {
            (OutOfReach::TakeBest, Some(best)) => Ok(best),
            (_, best) => Err(HydroError::ToleranceNotReached {
                tolerance,
                reached: best.map_or(f64::INFINITY, |best| best.relative_error()),
                surfaces,
                gap,
            }),
        };
    }
}
