//! Predicted time of expansions, from the orders that the gaps need and the operations for them.
//!
//! Times are counted, not measured, so that all machines and repeated runs decide alike.

use super::adaptive::first_orders;
use super::frame::{Frame, Surroundings};
use super::memory;
use super::orders::{Accuracy, Orders};
use super::spatial::{dense_numbers, dense_operations, is_factorised};
use crate::{HydroError, Medium, Spheres};

/// Operations per second in a dense factorisation, on two cores.
///
/// A system of 6000 multipoles takes one to two seconds with its assembly.
const DENSE_RATE: f64 = 3e10;

/// Operations per second in the eliminations on an axis, whose matrices are small.
///
/// A matrix of 3000 multipoles takes one to two seconds.
const AXIAL_RATE: f64 = 6e9;

/// Azimuthal numbers of the lowest orders of surface velocities, zero to six.
const AZIMUTHAL_NUMBERS: f64 = 7.0;

/// Seconds of a solve of few modes: allocations, coefficients of translation.
const LEAST_SECONDS: f64 = 1e-4;

/// Predicted seconds of [`super::resistance_best`] on two cores.
///
/// Rigid motions only; `columns` surface velocities add those of [`super::surface_flow`]. Right
/// within a factor of a few for sizes that take a second or more. Cost: that of the gaps.
///
/// # Errors
/// A tolerance that is not between `1e-13` and 1; spheres outside the medium; gaps below 0.001
/// smaller radii.
///
/// ```
/// use microhydro::{Accuracy, Medium, Spheres, multipole};
/// use nalgebra::Vector3;
/// let at = |n: usize| {
///     let centres = (0..n).map(|k| Vector3::new(3.0 * k as f64, (k * k) as f64, 0.0));
///     Spheres::new(centres.collect(), vec![1.0; n])
/// };
/// let seconds = |n| {
///     let accuracy = Accuracy::relative(1e-4);
///     multipole::predicted_seconds(&at(n)?, &Medium::Unbounded, &accuracy, 0)
/// };
/// let (few, many) = (seconds(3)?, seconds(100)?);
/// assert!(few < 0.1 && many > 100.0 * few, "{few} {many}");
/// # Ok::<(), microhydro::HydroError>(())
/// ```
pub fn predicted_seconds(
    spheres: &Spheres,
    medium: &Medium,
    accuracy: &Accuracy,
    columns: usize,
) -> Result<f64, HydroError> {
    let frame = Frame::new(spheres, medium);
    let orders = match accuracy.order {
        Some(order) => Orders::all(spheres.len(), medium, order),
        None => first_orders(spheres, medium, accuracy.tolerance)?,
    };
    let iteration = 3.0 * memory::of_iteration(&orders, columns as f64) / DENSE_RATE;
    let of_surfaces = match (columns, frame.collinear) {
        (0, _) => 0.0,
        (_, true) => {
            let sector = memory::of_factorisation(3.0 * degrees(&orders.without_gaps()));
            AZIMUTHAL_NUMBERS * sector / AXIAL_RATE
        }
        // Three systems: full, and lowered twice.
        (_, false) => iteration * cluster_factor(&orders) + of_gaps(&orders),
    };
    let of_resistance = match frame.collinear {
        true => axial(&orders.without_gaps()) / AXIAL_RATE,
        false => spatial(&orders, &frame),
    };
    Ok(LEAST_SECONDS + of_resistance + of_surfaces)
}

/// Highest order of the expansions that the gaps need for a relative error of the resistance.
///
/// # Errors
/// Those of [`predicted_seconds`].
pub fn predicted_order(
    spheres: &Spheres,
    medium: &Medium,
    tolerance: f64,
) -> Result<usize, HydroError> {
    Ok(first_orders(spheres, medium, tolerance)?
        .without_gaps()
        .highest())
}

/// Predicted degrees of freedom of [`super::resistance_best`], and MiB of its largest matrix.
///
/// # Errors
/// Those of [`predicted_seconds`].
pub fn predicted_size(
    spheres: &Spheres,
    medium: &Medium,
    tolerance: f64,
) -> Result<(usize, f64), HydroError> {
    let orders = first_orders(spheres, medium, tolerance)?;
    Ok((orders.dofs(), memory::mib(dense_numbers(&orders))))
}

/// Iterations with surface velocities over the usual number, if a surface has two narrow gaps.
///
/// The elimination for pairs may then eliminate too much, so that iterations reach their limit of
/// 500 instead of about 60, first beside the gaps and then with expansions of the highest order.
/// Measured for three squirmers in contact with gaps of 0.002: more than 39 s instead of 2.5.
fn cluster_factor(orders: &Orders) -> f64 {
    let surfaces = orders
        .gaps
        .keys()
        .flat_map(|&(first, second)| [first, second]);
    let mut surfaces: Vec<usize> = surfaces.collect();
    let all = surfaces.len();
    surfaces.sort_unstable();
    surfaces.dedup();
    if surfaces.len() < all {
        2.0 * 500.0 / 60.0
    } else {
        1.0
    }
}

/// Sum of the degrees of all expansions.
fn degrees(orders: &Orders) -> f64 {
    (orders.spheres.iter().sum::<usize>() + orders.container) as f64
}

/// Operations of the eliminations for the azimuthal numbers 0 and 1: two families of modes and one
/// for the first, three for the second.
fn axial(orders: &Orders) -> f64 {
    [1.0, 2.0, 3.0]
        .map(|families| memory::of_factorisation(families * degrees(orders)))
        .iter()
        .sum()
}

/// Seconds off an axis: one system, or two beside narrow gaps and the eliminations in these.
fn spatial(orders: &Orders, frame: &Frame) -> f64 {
    let is_wall = frame.surroundings == Surroundings::Wall;
    let of_system = match is_factorised(orders, is_wall) {
        Ok(true) => dense_operations(orders),
        _ => memory::of_iteration(orders, 6.0 * orders.spheres.len() as f64),
    };
    let systems = if orders.gaps.is_empty() { 1.0 } else { 2.0 };
    systems * of_system / DENSE_RATE + of_gaps(orders)
}

/// Seconds of the eliminations in narrow gaps: the azimuthal numbers 0 and 1, and higher ones with
/// lower orders, up to the order of the expansions.
fn of_gaps(orders: &Orders) -> f64 {
    let of_gap = |pair: [usize; 2]| memory::of_factorisation(3.0 * (pair[0] + pair[1]) as f64);
    let gaps = orders.gaps.iter().map(|(&(first, second), gap)| {
        let order = orders.of_expansion(first).max(orders.of_expansion(second));
        2.0 * of_gap(gap.singular) + order as f64 * of_gap(gap.regular)
    });
    gaps.sum::<f64>() / AXIAL_RATE
}
