//! Resistance to a requested accuracy: raises the orders until the error estimate is small enough.

use super::accuracy::Accuracy;
use super::fixed_order::{self, FIXED_ORDER_TOLERANCE};
use super::frame::Frame;
use super::memory;
use super::order::{self, GapCoordinates, MAX_ORDER_OFF_AXIS, Targets};
use super::orders::{MIN_ORDER, Orders};
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
    orders.off_axis = configurations
        .iter()
        .any(|one| !Frame::of(one, medium).collinear);
    for configuration in configurations {
        if configuration.len() != spheres {
            return Err(HydroError::Length {
                what: "spheres of a configuration",
                expected: spheres,
                found: configuration.len(),
            });
        }
        let found = adaptive(
            configuration,
            medium,
            tolerance,
            &orders,
            OutOfReach::Refuse,
        )?;
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

/// Number of attempts without a lower estimate after which rounding errors dominate it.
const MAX_STALLED: usize = 3;

/// Resistance to a tolerance from orders of at least `lowest`.
fn adaptive(
    spheres: &Spheres,
    medium: &Medium,
    tolerance: f64,
    lowest: &Orders,
    out_of_reach: OutOfReach,
) -> Result<Resistance, HydroError> {
    Accuracy::relative(tolerance).check()?;
    spheres.check_inside(medium)?;
    let n = spheres.len();
    memory::check_spheres(n)?;
    let on_axis = Frame::of(spheres, medium).collinear && !lowest.off_axis;
    let gaps = order::gaps(spheres, medium);
    let xi = GapCoordinates::narrowest_of(&gaps, n);
    let needed = |targets: Targets, highest: usize| {
        order::for_targets(&gaps, n, medium, targets, highest).at_least(lowest)
    };
    let mut targets = Targets {
        expansions: order::first_target(&xi.widened(), n, tolerance),
        gaps: order::first_target(&xi, n, tolerance),
    };
    let first = needed(targets, MAX_ORDER_OFF_AXIS);
    let cheap = |highest: &usize| first.limited(*highest, usize::MAX).dofs() <= FIRST_DOFS;
    let mut highest = (MIN_ORDER..=MAX_ORDER_OFF_AXIS)
        .rev()
        .find(cheap)
        .unwrap_or(MIN_ORDER);
    let mut orders = needed(targets, highest).affordable(on_axis);
    let (surfaces, gap) = spheres.narrowest_gap(medium);
    if first.affordable(on_axis) != first && out_of_reach == OutOfReach::Refuse {
        return Err(HydroError::TooClose {
            surfaces,
            gap,
            tolerance,
            needed: first.highest(),
            highest: orders.highest(),
        });
    }
    let mut best: Option<Resistance> = None;
    let mut stalled = 0;
    loop {
        let accuracy = targets.expansions.min(tolerance);
        let reached = match fixed_order::resistance(spheres, medium, &orders, accuracy) {
            // orders beyond the memory end the search, unless they are the first ones
            Err(HydroError::TooLarge { .. }) if best.is_some() => break,
            other => other?,
        };
        let estimate = reached.resistance.relative_error();
        if estimate <= tolerance {
            return Ok(reached.resistance);
        }
        let lowest_estimate = (best.as_ref()).map_or(f64::INFINITY, Resistance::relative_error);
        stalled = if estimate < 0.9 * lowest_estimate {
            0
        } else {
            stalled + 1
        };
        if estimate < lowest_estimate {
            best = Some(reached.resistance);
        }
        let limited = needed(targets, MAX_ORDER_OFF_AXIS) != needed(targets, highest);
        let of_expansions = reached.expansions > 0.4 * tolerance;
        let of_gaps = match on_axis {
            // on an axis the expansions resolve the gaps themselves
            true => of_expansions,
            false => reached.gaps > 0.4 * tolerance,
        };
        let last = orders.clone();
        if limited && of_expansions {
            let orders = (reached.expansions / tolerance).ln() / DECAY;
            highest += orders.clamp(1.0, 4.0) as usize;
        }
        // The lowest orders suffice for targets far below the one that selected them. The same
        // orders would give the same estimate, so the targets are lowered until the orders rise.
        for step in 0..MAX_STEPS {
            let lower = |target: f64, part: f64| {
                let factor = (0.4 * tolerance / part).clamp(0.01, 0.5);
                let further = if step < 8 { 0.1 } else { 1e-20 };
                target * if step == 0 { factor } else { further }
            };
            if of_expansions && !(limited && step == 0) {
                targets.expansions = lower(targets.expansions, reached.expansions);
            }
            if of_gaps {
                let part = if on_axis {
                    reached.expansions
                } else {
                    reached.gaps
                };
                targets.gaps = lower(targets.gaps, part);
            }
            orders = needed(targets, highest).affordable(on_axis);
            if orders != last {
                break;
            }
        }
        if orders == last || stalled == MAX_STALLED {
            break;
        }
    }
    match (out_of_reach, best) {
        (OutOfReach::TakeBest, Some(best)) => Ok(best),
        (_, best) => Err(HydroError::ToleranceNotReached {
            tolerance,
            reached: best.map_or(f64::INFINITY, |best| best.relative_error()),
            surfaces,
            gap,
        }),
    }
}

/// Number of degrees of freedom of the first orders: a second for their factorisation.
///
/// Narrow gaps are treated apart, so that lower orders than those of the gaps may suffice; the
/// estimate tells.
const FIRST_DOFS: usize = 6000;

/// Decay of the logarithm of the estimate for each order, in suspensions with gaps from 0.05 to 2.
///
/// Measured: 1 to 1.7. Too high orders cost more than one more attempt.
const DECAY: f64 = 1.2;

/// Attempts to raise the orders by lower targets; the last ones are below any number.
const MAX_STEPS: usize = 24;
