//! The weak form of Stokes flow without swirl, in cylindrical coordinates.
//!
//! With velocity `(u_z, u_r)` and `∫ f = 2π ∫ f r dr dz`,
//!
//! ```text
//! a(u, v) =  ∫ ∇u_z·∇v_z + ∇u_r·∇v_r + u_r v_r / r^2
//! b(v, q) = -∫ q (∂v_z/∂z + ∂v_r/∂r + v_r / r)
//! ```
//!
//! These are `∫ ∇u:∇v` and `-∫ q ∇·v` of the three-dimensional flow. Forces on bodies that do not
//! rotate are the same as those of the form with the symmetric gradient. On the axis `u_r = 0`.
//! (Bernardi, Dauge & Maday, Spectral Methods for Axisymmetric Domains, 1999.)

use nalgebra::{DMatrix, Dyn, MatrixView};

use crate::element::Table;
use crate::geometry_map::MapPoint;

/// The matrices of one element.
pub(crate) struct ElementMatrices {
    /// Stiffness of the axial velocity `u_z`.
    pub axial: DMatrix<f64>,
    /// Stiffness of the radial velocity `u_r`, which includes the term `u_r v_r / r^2`.
    pub radial: DMatrix<f64>,
    /// Divergence: rows are pressures, columns axial velocities.
    pub divergence_axial: DMatrix<f64>,
    /// Divergence: rows are pressures, columns radial velocities.
    pub divergence_radial: DMatrix<f64>,
    /// Diagonal of the pressure mass matrix.
    pub pressure_mass: Vec<f64>,
}

impl ElementMatrices {
    /// The matrices of an element with the geometry `points` and these basis functions.
    pub fn new(points: &[MapPoint], velocity: &Table, pressure: &Table) -> Self {
        let m = points.len();
        let [by_z, by_r] = derivatives(points, velocity);
        let over_radius = scaled(&velocity.values, |q| 1.0 / points[q].radius);
        let measure = |q: usize| points[q].measure;
        let axial = &by_z * transposed(&scaled(&by_z, measure))
            + &by_r * transposed(&scaled(&by_r, measure));
        let radial = &axial + &over_radius * transposed(&scaled(&over_radius, measure));
        let [divergence_axial, divergence_radial] =
            divergences(points, &pressure.values, &by_z, &by_r, &over_radius);
        let pressure_mass = (0..pressure.values.nrows())
            .map(|i| {
                (0..m)
                    .map(|q| measure(q) * pressure.values[(i, q)].powi(2))
                    .sum()
            })
            .collect();
        Self {
            divergence_axial,
            divergence_radial,
            axial,
            radial,
            pressure_mass,
        }
    }
}

/// The divergences of axial and radial velocities by their derivatives and their values over the
/// radius, as in [`ElementMatrices`].
pub(crate) fn divergences(
    points: &[MapPoint],
    pressures: &DMatrix<f64>,
    by_z: &DMatrix<f64>,
    by_r: &DMatrix<f64>,
    over_radius: &DMatrix<f64>,
) -> [DMatrix<f64>; 2] {
    let weighted = scaled(pressures, |q| -points[q].measure);
    [
        &weighted * transposed(by_z),
        &weighted * transposed(&(by_r + over_radius)),
    ]
}

/// Enters the divergences of axial and radial velocities into a matrix whose rows and columns are
/// axial velocities, radial velocities and pressures.
pub(crate) fn enter_divergences(divergences: [&DMatrix<f64>; 2], matrix: &mut DMatrix<f64>) {
    for (number, divergence) in divergences.into_iter().enumerate() {
        let (k, n) = divergence.shape();
        matrix
            .view_mut((2 * n, number * n), (k, n))
            .copy_from(divergence);
        matrix
            .view_mut((number * n, 2 * n), (n, k))
            .copy_from(&transposed(divergence));
    }
}

/// Derivatives of the basis functions along the axis and away from it: one function per row, one
/// point per column.
pub(crate) fn derivatives(points: &[MapPoint], table: &Table) -> [DMatrix<f64>; 2] {
    let [by_x, by_y] = &table.gradients;
    [0, 1].map(|d| {
        DMatrix::from_fn(by_x.nrows(), points.len(), |i, q| {
            points[q].derivatives([by_x[(i, q)], by_y[(i, q)]])[d]
        })
    })
}

/// The matrix with column `q` multiplied by `factor(q)`.
pub(crate) fn scaled(matrix: &DMatrix<f64>, factor: impl Fn(usize) -> f64) -> DMatrix<f64> {
    let mut scaled = matrix.clone();
    for (q, mut column) in scaled.column_iter_mut().enumerate() {
        column *= factor(q);
    }
    scaled
}

/// The transposed matrix, without a copy.
pub(crate) fn transposed(matrix: &DMatrix<f64>) -> MatrixView<'_, f64, Dyn, Dyn, Dyn, Dyn> {
    let (rows, columns) = matrix.shape();
    MatrixView::from_slice_with_strides_generic(
        matrix.as_slice(),
        Dyn(columns),
        Dyn(rows),
        Dyn(rows),
        Dyn(1),
    )
}
