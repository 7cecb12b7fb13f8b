//! Mobility of spheres at any positions: Schur complement by factorisation or by iteration.

use nalgebra::DMatrix;

use super::elimination::{eliminate, schur_complement};
use super::frame::{Frame, Surroundings};
use super::memory;
use super::modes::{Family, Modes};
use super::narrow_gap::Block;
use super::orders::Orders;
use super::scaled::ScaledMobility;
use super::system::{MultiVector, System};
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
    let dense = memory::dense_is_cheaper(orders, frame.surroundings == Surroundings::Wall)?;
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
    let dense = memory::dense_is_cheaper(orders, frame.surroundings == Surroundings::Wall)?;
    let mut system = System::new(frame, radii, orders, 0.1 * tolerance);
    system.add_blocks(blocks);
    match dense {
        true => full_by_factorisation(&system),
        false => Ok(by_iteration(&system.store_couplings(), residual)?.full),
    }
}

/// Scaled mobility matrices for the orders of a system and two orders lower, by one factorisation
/// of the whole matrix, for few multipoles per sphere.
///
/// Iterations consist of many small products per pair of spheres and run at a twentieth of the
/// speed of one large factorisation. The factorisation also gives both orders at once, and its cost
/// does not depend on the condition number, which narrow gaps make large.
///
/// Cost: `n^3/3` operations and `n^2` numbers for `n` degrees of freedom.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
fn by_factorisation(system: &System) -> Result<ScaledMobility, HydroError> {
    let (elimination_rows, lower_size) = elimination_rows(system);
    let rigid = 6 * system.spheres;
    let [full, lower] = eliminate(system.dense(&elimination_rows), rigid, lower_size)?;
    Ok(ScaledMobility { full, lower })
}

/// Scaled mobility matrix for the orders of a system alone.
///
/// # Errors
/// [`HydroError::FactorisationFailed`].
fn full_by_factorisation(system: &System) -> Result<DMatrix<f64>, HydroError> {
    let (elimination_rows, _) = elimination_rows(system);
    schur_complement(system.dense(&elimination_rows), 6 * system.spheres)
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
    let columns = a.first().map_or(0, faer::Mat::ncols);
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
