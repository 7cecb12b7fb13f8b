//! Memory of the expansions, checked before it is allocated.

use super::modes::FAMILIES;
use super::orders::Orders;
use crate::HydroError;

/// Most memory that a resistance or a velocity field may take, in MiB.
///
/// A dense matrix of 28000 multipoles, whose factorisation takes some minutes, or the matrices over
/// the rigid motions of 1600 spheres.
pub(super) const MAX_MIB: f64 = 6144.0;

/// Bytes of a number.
const BYTES_PER_NUMBER: f64 = 8.0;

/// MiB of an amount of numbers.
pub(super) fn mib(numbers: f64) -> f64 {
    BYTES_PER_NUMBER * numbers / (1024.0 * 1024.0)
}

/// Checks an amount of memory for `numbers` numbers and `dofs` degrees of freedom.
///
/// # Errors
/// [`HydroError::TooLarge`].
pub(super) fn check(numbers: f64, dofs: f64) -> Result<(), HydroError> {
    let mib = mib(numbers);
    if mib <= MAX_MIB {
        return Ok(());
    }
    Err(HydroError::TooLarge {
        dofs,
        mib,
        highest: MAX_MIB,
    })
}

/// Number of multipoles, as a number that does not overflow.
pub(super) fn dofs(orders: &Orders) -> f64 {
    let of = |order: usize| {
        let families = FAMILIES.iter().map(|family| {
            let top = (order as f64 - family.shift() as f64).max(0.0);
            top * (top + 2.0)
        });
        families.sum::<f64>()
    };
    orders.spheres.iter().map(|&l| of(l)).sum::<f64>() + of(orders.container)
}

/// Checks the memory of the matrices over the rigid motions of a number of spheres.
///
/// # Errors
/// [`HydroError::TooLarge`].
pub(crate) fn check_spheres(spheres: usize) -> Result<(), HydroError> {
    let motions = 6.0 * spheres as f64;
    check(RIGID_MATRICES * motions * motions, motions)
}

/// Checks the memory of expansions on one axis.
///
/// # Errors
/// [`HydroError::TooLarge`].
pub(super) fn check_on_axis(orders: &Orders) -> Result<(), HydroError> {
    let degrees: f64 = orders.spheres.iter().map(|&l| l as f64).sum();
    let dofs = 3.0 * (degrees + orders.container as f64);
    check(dofs * dofs + of_rigid_motions(orders), dofs)
}

/// Whether the dense matrix of expansions at any positions is affordable and the cheaper way.
///
/// # Errors
/// [`HydroError::TooLarge`] if neither a factorisation nor an iteration is affordable.
pub(super) fn dense_is_cheaper(orders: &Orders, wall: bool) -> Result<bool, HydroError> {
    let dofs = dofs(orders);
    let spheres = orders.spheres.len() as f64;
    let images = if wall { 0.5 * dofs * dofs } else { 0.0 };
    let common = images + of_rigid_motions(orders);
    let dense = dofs * dofs + common;
    let columns = 6.0 * spheres;
    let iteration = couplings(orders) + ITERATION_PANELS * columns * dofs + common;
    let dense_operations = of_factorisation(dofs);
    let iteration_operations = of_iteration(orders, columns);
    match check(dense, dofs) {
        Ok(()) => Ok(dense_operations <= iteration_operations || check(iteration, dofs).is_err()),
        Err(_) => check(iteration, dofs).map(|()| false),
    }
}

/// Operations of a factorisation of a dense matrix of this size.
pub(super) fn of_factorisation(dofs: f64) -> f64 {
    dofs.powi(3) / 3.0
}

/// Operations of a factorisation that take as long as an iteration for a number of right-hand
/// sides, for both orders.
pub(super) fn of_iteration(orders: &Orders, columns: f64) -> f64 {
    // A product has two directions, with a multiplication and an addition, and two rotations.
    ITERATION_SLOWDOWN * EXPECTED_ITERATIONS * 8.0 * couplings(orders) * columns
}

/// Numbers in the rotations and couplings of all pairs: about `4.4 L^3` for two expansions of the
/// order `L`.
fn couplings(orders: &Orders) -> f64 {
    4.4 * 0.5 * orders.spheres.len() as f64 * cubes_of_orders(orders)
}

/// Checks the memory of one solution for all expansions.
///
/// # Errors
/// [`HydroError::TooLarge`].
pub(super) fn check_one_solution(orders: &Orders, wall: bool) -> Result<(), HydroError> {
    let dofs = dofs(orders);
    let images = if wall { 0.5 * dofs * dofs } else { 0.0 };
    let spheres = orders.spheres.len() as f64 + 1.0;
    let cubes = cubes_of_orders(orders);
    check(
        4.4 * 0.5 * spheres * cubes + ITERATION_PANELS * dofs + images,
        dofs,
    )
}

/// Panels of all degrees of freedom for an iteration: rhs, solution, residual, direction and
/// temporaries.
const ITERATION_PANELS: f64 = 7.0;

/// Iterations for both orders, and the time of an operation in an iteration relative to one in a
/// factorisation, because the products are small.
const EXPECTED_ITERATIONS: f64 = 60.0;
const ITERATION_SLOWDOWN: f64 = 20.0;

/// Matrices over the rigid motions: mobilities, resistances and temporaries.
const RIGID_MATRICES: f64 = 8.0;

/// Sum of the cubes of all orders.
fn cubes_of_orders(orders: &Orders) -> f64 {
    let cube = |l: usize| (l as f64).powi(3);
    orders.spheres.iter().map(|&l| cube(l)).sum::<f64>() + cube(orders.container)
}

fn of_rigid_motions(orders: &Orders) -> f64 {
    RIGID_MATRICES * (6.0 * orders.spheres.len() as f64).powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Medium;

    /// 140 spheres were solved by iteration, in 47 s instead of 3.
    #[test]
    fn many_spheres_are_factorised_and_few_of_high_order_iterated() {
        let orders = |spheres: usize, order: usize| Orders::all(spheres, &Medium::Unbounded, order);
        for (spheres, order) in [(125, 4), (140, 4), (200, 4), (400, 4), (1000, 2)] {
            assert!(dense_is_cheaper(&orders(spheres, order), false).unwrap());
        }
        assert!(!dense_is_cheaper(&orders(3, 60), false).unwrap());
        let error = dense_is_cheaper(&orders(10_000, 2), false).unwrap_err();
        assert!(
            matches!(error, HydroError::TooLarge { mib, .. } if mib > MAX_MIB),
            "{error}"
        );
    }

    #[test]
    fn numbers_of_multipoles_agree_with_the_modes() {
        for order in 2..7 {
            let orders = Orders::all(3, &Medium::Unbounded, order);
            assert!((dofs(&orders) - orders.dofs() as f64).abs() < 0.5);
        }
    }
}
