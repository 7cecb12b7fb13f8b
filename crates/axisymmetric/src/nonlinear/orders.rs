//! Elements of increasing order until a tolerance is met.

use crate::AxisymmetricError;
use crate::solver::MAX_ORDER;

/// First order of the elements.
pub(super) const FIRST_ORDER: usize = 4;

/// Smallest tolerance, ten times the error of the iterations.
const MIN_TOLERANCE: f64 = 1e-10;

/// Edge length relative to the distance from the focus of the nearest body.
///
/// Two thirds of that of Stokes flow: boundary layers and wakes vary faster.
pub(crate) const GROWTH: f64 = 0.45;

/// The solution of the lowest order that differs from the one before by at most `tolerance`, with
/// that difference.
///
/// `solve` has the order and the solution of the order before.
///
/// # Errors
/// [`AxisymmetricError::InvalidTolerance`], [`AxisymmetricError::FlowNotConverged`], those of
/// `solve`.
pub(crate) fn raise_order<S>(
    tolerance: f64,
    solve: impl Fn(usize, Option<&S>) -> Result<S, AxisymmetricError>,
    difference: impl Fn(&S, &S) -> f64,
) -> Result<(S, f64), AxisymmetricError> {
    if !(MIN_TOLERANCE..1.0).contains(&tolerance) {
        return Err(AxisymmetricError::InvalidTolerance {
            tolerance,
            limit: MIN_TOLERANCE,
        });
    }
    let mut last = solve(FIRST_ORDER, None)?;
    let mut reached = f64::INFINITY;
    for order in FIRST_ORDER + 1..=MAX_ORDER {
        let next = solve(order, Some(&last))?;
        reached = difference(&last, &next);
        if reached <= tolerance {
            return Ok((next, reached));
        }
        last = next;
    }
    Err(AxisymmetricError::FlowNotConverged {
        tolerance,
        reached,
        order: MAX_ORDER,
    })
}
