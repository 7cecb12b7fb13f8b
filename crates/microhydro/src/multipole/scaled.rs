//! Mobility matrices over scaled modes, and their conversion to physical units.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::elimination;
use super::rotation::AXIS_OF_M;
use crate::HydroError;

/// Scaled mobility matrices for the requested orders and for orders lower by two.
///
/// In these units each rigid motion of a lone sphere has mobility 1. Six rows per sphere:
/// translation, then rotation, each with `m = -1, 0, 1` (the axes y, z, x). Rotations have the sign
/// of the harmonic `X_1 = n × e`.
pub(super) struct ScaledMobility {
    /// Matrix for the requested orders.
    pub full: DMatrix<f64>,
    /// Matrix for orders lower by two.
    pub lower: DMatrix<f64>,
}

impl ScaledMobility {
    /// Zero matrices for a number of spheres.
    pub fn zeros(spheres: usize) -> Self {
        Self {
            full: DMatrix::zeros(6 * spheres, 6 * spheres),
            lower: DMatrix::zeros(6 * spheres, 6 * spheres),
        }
    }
}

/// Resistance matrix from a scaled mobility matrix, along the axes of the frame.
pub(super) fn unscaled_inverse(
    mobility: &DMatrix<f64>,
    radii: &[f64],
) -> Result<DMatrix<f64>, HydroError> {
    let inverse = elimination::inverse(mobility, "mobility matrix")?;
    Ok(unscaled(&inverse, radii, |unit| unit))
}

/// Converts a matrix over scaled modes to physical units and to x, y, z order.
///
/// Rows and columns are multiplied by `factor` of their [`drag_units`].
pub(super) fn unscaled(
    matrix: &DMatrix<f64>,
    radii: &[f64],
    factor: impl Fn(f64) -> f64,
) -> DMatrix<f64> {
    let n = matrix.nrows();
    let units: Vec<f64> = drag_units(radii).into_iter().map(factor).collect();
    let physical_row = |row: usize| 3 * (row / 3) + AXIS_OF_M[row % 3];
    let mut result = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..n {
            result[(physical_row(i), physical_row(j))] = units[i] * units[j] * matrix[(i, j)];
        }
    }
    result
}

/// Square roots of the drag coefficients of lone spheres, in the order of [`ScaledMobility`].
///
/// Negative for rotations: the harmonic `X_1` is `n × e`, but a rotation about `e` is `e × n`.
pub(super) fn drag_units(radii: &[f64]) -> Vec<f64> {
    let of = |&a: &f64| {
        let (drag, torque) = ((6.0 * PI * a).sqrt(), (8.0 * PI * a.powi(3)).sqrt());
        [drag, drag, drag, -torque, -torque, -torque]
    };
    radii.iter().flat_map(of).collect()
}
