//! Mobility of spheres at any positions: Schur complement by factorisation or by iteration.

use std::ops::Range;

use faer::Mat;
use nalgebra::DMatrix;

use super::elimination::{divide_by_factor, eliminate, schur_complement, subtract_square};
use super::frame::{Frame, Surroundings};
use super::memory;
use super::modes::{Family, Modes};
use super::narrow_gap::Block;
use super::orders::Orders;
use super::scaled::ScaledMobility;
use super::system::{DenseSystem, MultiVector, System};
use crate::HydroError;

/// Scaled mobility matrices of spheres at any positions.
///
/// For the given orders and for orders lower by two. Couplings below a tenth of `tolerance` are
/// neglected. Systems of few spheres with high orders are solved by iterations that stop at
/// `residual`.
///
/// # Errors
/// [`HydroError::NotConverged`], [`HydroError::FactorisationFailed`], [`HydroError::TooLarge`].
pub(crate) fn mobility(
    frame: &Frame,
    radii: &[f64],
    orders: &Orders,
    (tolerance, residual): (f64, f64),
) -> Result<ScaledMobility, HydroError> {
    let dense = is_factorised(orders, frame.surroundings == Surroundings::Wall)?;
    let system = System::new(frame, radii, orders, 0.1 * tolerance);
    match dense {
        true => by_factorisation(&system),
        false => by_iteration(&system.store_couplings(), residual),
    }
}

/// As [`mobility`], for the given orders alone and with further `blocks` of the Galerkin matrix.
///
/// # Errors
/// As [`mobility`].
pub(crate) fn mobility_with_blocks(
    frame: &Frame,
    radii: &[f64],
    orders: &Orders,
    blocks: Vec<Block>,
    (tolerance, residual): (f64, f64),
) -> Result<DMatrix<f64>, HydroError> {
    let dense = is_factorised(orders, frame.surroundings == Surroundings::Wall)?;
    let mut system = System::new(frame, radii, orders, 0.1 * tolerance);
    system.add_blocks(blocks);
    match dense {
        true => full_by_factorisation(&system),
        false => Ok(by_iteration(&system.store_couplings(), residual)?.full),
    }
}

/// Scaled mobility matrices for the orders of a system and two orders lower, by factorisation of
/// the matrix of the spheres, for few multipoles per sphere.
///
/// Iterations consist of many small products per pair of spheres and run at a twentieth of the
/// speed of one large factorisation. The factorisation also gives both orders at once, and its cost
/// does not depend on the condition number, which narrow gaps make large. The modes of a container
/// do not couple to each other, so that their elimination is a product; then the matrices of both
/// orders differ by the container's highest modes and have a factorisation each.
///
/// Cost: [`dense_operations`] and [`dense_numbers`].
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
fn by_factorisation(system: &System) -> Result<ScaledMobility, HydroError> {
    let (rigid, order) = (6 * system.spheres, EliminationOrder::new(system));
    let DenseSystem {
        mut spheres,
        container,
        ..
    } = system.dense(&order.rows);
    if container.ncols() == 0 {
        let [full, lower] = eliminate(spheres, rigid, order.lower)?;
        return Ok(ScaledMobility { full, lower });
    }
    let (low, highest) = container.split_at_col(order.lower_of_container);
    subtract_square(&mut spheres, low);
    let first = spheres.nrows() - rigid;
    let kept: Vec<usize> = (0..order.lower).chain(first..spheres.nrows()).collect();
    let lower = Mat::from_fn(kept.len(), kept.len(), |i, j| spheres[(kept[i], kept[j])]);
    subtract_square(&mut spheres, highest);
    Ok(ScaledMobility {
        full: schur_complement(spheres, rigid)?,
        lower: schur_complement(lower, rigid)?,
    })
}

/// Scaled mobility matrix for the orders of a system alone.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
fn full_by_factorisation(system: &System) -> Result<DMatrix<f64>, HydroError> {
    let mut dense = system.dense(&EliminationOrder::new(system).rows);
    if let Some(own) = dense.own {
        divide_by_factor(&mut dense.container, own)?;
    }
    subtract_square(&mut dense.spheres, dense.container.as_ref());
    schur_complement(dense.spheres, 6 * system.spheres)
}

/// Operations of both factorisations: `n^3/3` for `n` modes of the spheres, and `n^2` for each mode
/// of the container; in narrow gaps to it, that of all modes.
pub(super) fn dense_operations(orders: &Orders) -> f64 {
    let (spheres, container) = dofs_apart(orders);
    match couples_to_itself(orders) {
        true => memory::of_factorisation(spheres + container),
        false => memory::of_factorisation(spheres) + spheres * spheres * container,
    }
}

/// Whether modes of the container couple to each other, by eliminations in narrow gaps.
fn couples_to_itself(orders: &Orders) -> bool {
    orders.gaps.keys().any(|gap| gap.1 == orders.spheres.len())
}

/// Numbers in the matrices of the factorisations.
pub(super) fn dense_numbers(orders: &Orders) -> f64 {
    let (spheres, container) = dofs_apart(orders);
    let own = if couples_to_itself(orders) {
        container
    } else {
        0.0
    };
    // both orders have a matrix of the spheres
    let of_spheres = if container > 0.0 { 2.0 } else { 1.0 };
    of_spheres * spheres * spheres + spheres * container + own * own
}

/// Multipoles of the spheres and of the container.
fn dofs_apart(orders: &Orders) -> (f64, f64) {
    let spheres = memory::dofs(&without_container(orders));
    (spheres, memory::dofs(orders) - spheres)
}

fn without_container(orders: &Orders) -> Orders {
    Orders {
        container: 0,
        ..orders.clone()
    }
}

/// Whether a factorisation is affordable and cheaper than iterations.
///
/// # Errors
/// [`HydroError::TooLarge`] if neither is affordable.
pub(super) fn is_factorised(orders: &Orders, is_wall: bool) -> Result<bool, HydroError> {
    match memory::check(dense_numbers(orders), memory::dofs(orders)) {
        // a mode of the container costs an iteration more than a factorisation
        Ok(()) => Ok(
            memory::dense_is_cheaper(&without_container(orders), is_wall)?
                || memory::dense_is_cheaper(orders, is_wall).is_err(),
        ),
        Err(_) => memory::dense_is_cheaper(orders, is_wall),
    }
}

/// Order in which the modes of the spheres are eliminated, and those of the container before them.
struct EliminationOrder {
    /// Row of each mode: first those of the lower order, then the others, then the rigid motions.
    rows: Vec<Vec<usize>>,
    /// Number of modes of the spheres of the lower order.
    lower: usize,
    /// Number of modes of the container of the lower order.
    lower_of_container: usize,
}

impl EliminationOrder {
    fn new(system: &System) -> Self {
        let lower = system.mask(|modes, family, l| modes.in_lower_order(family, l));
        let is_rigid = system.mask(|_, family, l| l == 1 && family != Family::Source);
        let mut rows: Vec<Vec<usize>> = lower.iter().map(|mask| vec![0; mask.len()]).collect();
        let mut number = |expansions: Range<usize>, is_kept: bool, wanted: bool, first: usize| {
            let mut next = first;
            for expansion in expansions {
                for row in 0..rows[expansion].len() {
                    let is_last = is_kept && is_rigid[expansion][row];
                    if lower[expansion][row] == wanted && !is_last {
                        rows[expansion][row] = next;
                        next += 1;
                    }
                }
            }
            next
        };
        let (spheres, all) = (system.spheres, system.expansions.len());
        let low = number(0..spheres, true, true, 0);
        let mut next = number(0..spheres, true, false, low);
        // the container has no rigid motion to keep
        let low_of_container = number(spheres..all, false, true, 0);
        number(spheres..all, false, false, low_of_container);
        for (sphere, rows) in rows.iter_mut().enumerate().take(spheres) {
            for row in system.rigid_rows(sphere) {
                rows[row] = next;
                next += 1;
            }
        }
        Self {
            rows,
            lower: low,
            lower_of_container: low_of_container,
        }
    }
}

/// Scaled mobility matrices by conjugate gradients.
///
/// With the rigid motions `r` and all other modes `h` the mobility is
/// `M = A_rr - A_rh A_hh^(-1) A_hr`. Errors of the iteration enter squared, so `residual` needs
/// half of the digits only.
///
/// # Errors
/// [`HydroError::NotConverged`].
fn by_iteration(system: &System, residual: f64) -> Result<ScaledMobility, HydroError> {
    let n = system.spheres;
    let (coupled, rigid_block) = rigid_columns(system);
    let is_rigid = |family: Family, l: usize| l == 1 && family != Family::Source;
    let eliminated = |included: &dyn Fn(Modes, Family, usize) -> bool| {
        let mut mask = system.mask(|modes, f, l| included(modes, f, l) && !is_rigid(f, l));
        // the container has no rigid motion: all its modes are eliminated
        if let Some(container) = mask.get_mut(n) {
            let all = system.mask(included);
            container.clone_from(&all[n]);
        }
        mask
    };
    let lower = eliminated(&|modes, f, l| modes.in_lower_order(f, l));
    let full = eliminated(&|_, _, _| true);
    let mut x = system.zeros(6 * n);
    let mut schur = |mask: &[Vec<bool>]| -> Result<DMatrix<f64>, HydroError> {
        let r = system.solve(mask, &coupled, &mut x, residual)?;
        // the error of x^T b + x^T r is the square of that of x
        let product = transposed_product(&x, &coupled) + transposed_product(&x, &r);
        let symmetric = (&product + product.transpose()) * 0.5;
        Ok(&rigid_block - symmetric)
    };
    let lower = schur(&lower)?;
    let full = schur(&full)?;
    Ok(ScaledMobility { full, lower })
}

/// Scaled mobility of rigid motions with only the container eliminated: no reflections between
/// spheres.
pub(crate) fn rigid_mobility(frame: &Frame, radii: &[f64], orders: &Orders) -> DMatrix<f64> {
    let system = System::new(frame, radii, orders, 0.0).store_couplings();
    let (coupled, rigid_block) = rigid_columns(&system);
    match coupled.get(radii.len()) {
        Some(container) => {
            let container = vec![container.clone()];
            rigid_block - transposed_product(&container, &container)
        }
        None => rigid_block,
    }
}

/// Columns of the matrix for the rigid motions of all spheres, and the rigid rows of these columns.
fn rigid_columns(system: &System) -> (MultiVector, DMatrix<f64>) {
    let n = system.spheres;
    let mut rigid = system.zeros(6 * n);
    for sphere in 0..n {
        for (k, row) in system.rigid_rows(sphere).into_iter().enumerate() {
            rigid[sphere][(row, 6 * sphere + k)] = 1.0;
        }
    }
    let coupled = system.apply(&rigid);
    let rigid_block = DMatrix::from_fn(6 * n, 6 * n, |i, j| {
        coupled[i / 6][(system.rigid_rows(i / 6)[i % 6], j)]
    });
    (coupled, rigid_block)
}

fn transposed_product(a: &MultiVector, b: &MultiVector) -> DMatrix<f64> {
    let columns = a.first().map_or(0, Mat::ncols);
    let mut product = DMatrix::zeros(columns, columns);
    for (a, b) in a.iter().zip(b) {
        let block = a.transpose() * b;
        for j in 0..columns {
            for i in 0..columns {
                product[(i, j)] += block[(i, j)];
            }
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;
    use crate::{Medium, Spheres};

    #[test]
    fn elimination_at_once_and_by_iteration_agree() {
        let centres = vec![
            Vector3::new(0.0, 0.0, 0.5),
            Vector3::new(2.5, 0.3, 0.0),
            Vector3::new(0.4, 3.0, 1.0),
        ];
        let spheres = Spheres::new(centres, vec![1.0, 0.8, 1.2]).unwrap();
        let ball = Medium::Ball {
            centre: Vector3::zeros(),
            radius: 9.0,
        };
        let wall = Medium::wall(Vector3::new(0.0, 0.0, -2.0), Vector3::z()).unwrap();
        for medium in [Medium::Unbounded, ball, wall] {
            let frame = Frame::new(&spheres, &medium);
            let orders = Orders::all(3, &medium, 5);
            let system = System::new(&frame, spheres.radii(), &orders, 1e-14).store_couplings();
            let at_once = by_factorisation(&system).unwrap();
            // errors of the iteration enter squared
            let steps = by_iteration(&system, 1e-7).unwrap();
            assert!((at_once.full - steps.full).amax() < 1e-13);
            assert!((at_once.lower - steps.lower).amax() < 1e-13);
        }
    }
}
