//! Spheres anywhere: the mobility by elimination of all multipoles beyond the rigid motions.

use nalgebra::DMatrix;

use super::Scaled;
use super::frame::Frame;
use super::modes::{Family, Modes};
use super::order::Orders;
use super::system::{Panel, System};
use crate::HydroError;

/// Scaled mobilities of spheres in space, for the orders asked for and for two less.
///
/// Couplings below a tenth of `tolerance` are left out. With the rigid motions `r` and all other modes `h`: $M = A_{rr} - A_{rh} A_{hh}^{-1} A_{hr}$: an error of the
/// iteration enters squared, so that `residual` needs half its digits only.
///
/// # Errors
/// [`HydroError::NotConverged`].
pub(crate) fn mobility(
    frame: &Frame,
    radii: &[f64],
    orders: &Orders,
    (tolerance, residual): (f64, f64),
) -> Result<Scaled, HydroError> {
    let system = System::new(frame, radii, orders, 0.1 * tolerance);
    let n = radii.len();
    let (coupled, own) = rigid_columns(&system);
    let is_rigid = |family: Family, l: usize| l == 1 && family != Family::Source;
    let beyond = |kept: &dyn Fn(Modes, Family, usize) -> bool| {
        let mut mask = system.mask(|modes, f, l| kept(modes, f, l) && !is_rigid(f, l));
        // the container has no rigid motion to keep: all its modes are eliminated
        if let Some(container) = mask.get_mut(n) {
            let all = system.mask(kept);
            container.clone_from(&all[n]);
        }
        mask
    };
    let lower = beyond(&|modes, f, l| modes.in_lower_order(f, l));
    let full = beyond(&|_, _, _| true);
    let mut x = system.zeros(6 * n);
    let mut schur = |mask: &[Vec<bool>]| -> Result<DMatrix<f64>, HydroError> {
        let r = system.solve(mask, &coupled, &mut x, residual)?;
        // x^T b + x^T r errs by the square of the residual
        let product = transposed_product(&x, &coupled) + transposed_product(&x, &r);
        let symmetric = (&product + product.transpose()) * 0.5;
        Ok(&own - symmetric)
    };
    let lower = schur(&lower)?;
    let full = schur(&full)?;
    Ok(Scaled { full, lower })
}

/// The scaled mobility of rigid motions alone, with the container eliminated: nothing is reflected between spheres.
pub(crate) fn rigid_mobility(frame: &Frame, radii: &[f64], orders: &Orders) -> DMatrix<f64> {
    let system = System::new(frame, radii, orders, 0.0);
    let (coupled, own) = rigid_columns(&system);
    match coupled.get(radii.len()) {
        Some(container) => {
            let container = vec![container.clone()];
            own - transposed_product(&container, &container)
        }
        None => own,
    }
}

/// The system's columns of the spheres' rigid motions, and their rigid rows.
fn rigid_columns(system: &System) -> (Panel, DMatrix<f64>) {
    let n = system.spheres;
    let mut rigid = system.zeros(6 * n);
    for sphere in 0..n {
        for (k, row) in system.rigid_rows(sphere).into_iter().enumerate() {
            rigid[sphere][(row, 6 * sphere + k)] = 1.0;
        }
    }
    let coupled = system.apply(&rigid);
    let own = DMatrix::from_fn(6 * n, 6 * n, |i, j| {
        coupled[i / 6][(system.rigid_rows(i / 6)[i % 6], j)]
    });
    (coupled, own)
}

fn transposed_product(a: &Panel, b: &Panel) -> DMatrix<f64> {
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
