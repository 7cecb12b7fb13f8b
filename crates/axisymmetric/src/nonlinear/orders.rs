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

/// The same on the finest mesh of fluids with a viscosity law, which two refinements reach.
pub(super) const MIN_GROWTH: f64 = 0.2;

/// Factor on edge lengths by a refinement.
pub(super) const REFINEMENT: f64 = 2.0 / 3.0;

/// The solution of the lowest order that differs from the one before by at most the first of
/// `tolerances`, with that difference; else that of the highest order, if it differs from the one
/// before by at most the second.
///
/// Low orders are not compared with the second: two of them may agree by accident, as they did at a
/// Reynolds number of 80. `solve` has the order and the solution of the order before.
///
/// # Errors
/// [`AxisymmetricError::InvalidTolerance`], [`AxisymmetricError::FlowNotConverged`], those of
/// `solve`.
pub(crate) fn raise_order<S>(
    [tolerance, accepted]: [f64; 2],
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
    if reached <= accepted {
        return Ok((last, reached));
    }
    Err(AxisymmetricError::FlowNotConverged {
        tolerance,
        reached,
        order: MAX_ORDER,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orders 5 and 6 agree to 1e-5 by accident; the others differ by 1e-3, the highest two by
    /// 1e-4.
    #[test]
    fn bug_low_orders_that_agreed_by_accident_were_accepted_with_their_difference() {
        let solve = |order: usize, _: Option<&f64>| {
            Ok(match order {
                FIRST_ORDER => 1.0,
                5 => 1.01,
                6 => 1.01001,
                MAX_ORDER => 1e-4,
                order => {
                    1e-3 * (MAX_ORDER - order) as f64
                        - if order + 1 == MAX_ORDER { 1e-3 } else { 0.0 }
                }
            })
        };
        let difference = |a: &f64, b: &f64| (a - b).abs();
        let (found, error) = raise_order([1e-7, 1e-3], solve, difference).unwrap();
        assert_eq!((found, error), (1e-4, 1e-4));
        // what low orders reach is accepted as a tolerance only
        let (found, _) = raise_order([1.1e-5, 1.1e-5], solve, difference).unwrap();
        assert_eq!(found, 1.01001);
        let refused = raise_order([1e-7, 1e-5], solve, difference);
        assert!(matches!(
            refused,
            Err(AxisymmetricError::FlowNotConverged { reached, .. }) if reached == 1e-4
        ));
    }
}
