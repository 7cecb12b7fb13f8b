//! Grand resistance matrix of bodies of revolution on one axis.

use std::f64::consts::PI;

use axisymmetric::{AxialResistance, AxialSpheroid, SurfaceResistance};
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Resistances of one configuration.
pub(crate) struct Resistances {
    /// To motions along the axis, and to the modes of the surfaces if there are `surfaces`.
    pub axial: AxialResistance,
    /// Modes of the surfaces, with slip or a background flow.
    pub surfaces: Option<SurfaceResistance>,
    /// To rotations about the axis, with torques.
    pub spin: Option<AxialResistance>,
}

/// Grand resistance matrix from the resistances along and about the axis.
///
/// For motions that are zero by symmetry it has the entries of single spheres.
pub(crate) fn grand_resistance(
    shapes: &[AxialSpheroid],
    axis: &Vector3<f64>,
    axial: &DMatrix<f64>,
    spin: Option<&DMatrix<f64>>,
) -> DMatrix<f64> {
    let n = shapes.len();
    let along: Matrix3<f64> = axis * axis.transpose();
    let across = Matrix3::identity() - along;
    let mut matrix = DMatrix::zeros(6 * n, 6 * n);
    for i in 0..n {
        for j in 0..n {
            let block = along * axial[(i, j)];
            matrix
                .fixed_view_mut::<3, 3>(6 * i, 6 * j)
                .copy_from(&block);
        }
        let size = shapes[i].axial.max(shapes[i].equatorial);
        let (drag, torque) = (6.0 * PI * size, 8.0 * PI * size.powi(3));
        let mut forces = matrix.fixed_view_mut::<3, 3>(6 * i, 6 * i);
        forces += across * drag;
        let mut torques = matrix.fixed_view_mut::<3, 3>(6 * i + 3, 6 * i + 3);
        torques += match spin {
            Some(_) => across * torque,
            None => Matrix3::identity() * torque,
        };
        for j in 0..n {
            let about = spin.map_or(0.0, |spin| spin[(i, j)]);
            let mut block = matrix.fixed_view_mut::<3, 3>(6 * i + 3, 6 * j + 3);
            block += along * about;
        }
    }
    matrix
}
