//! Resistance matrices with error estimates.

use nalgebra::DMatrix;

/// Resistance matrix `R` of motions along the axis or about it, with an error estimate.
///
/// `F_i = sum_j R_ij U_j` are the forces (torques) that the bodies exert on the fluid when they
/// move with the velocities (angular velocities) `U_j`. The viscosity is 1. `R` is symmetric
/// positive definite.
#[derive(Clone, Debug, PartialEq)]
pub struct AxialResistance {
    pub(crate) matrix: DMatrix<f64>,
    pub(crate) lower_order: DMatrix<f64>,
    pub(crate) error_factor: f64,
    pub(crate) dofs: usize,
    pub(crate) order: usize,
    pub(crate) triangles: usize,
    pub(crate) residual: f64,
}

/// Largest difference of entries `R_ij`, relative to `sqrt(R_ii R_jj)` of the second matrix.
pub(crate) fn distance(one: &DMatrix<f64>, other: &DMatrix<f64>) -> f64 {
    let mut largest = 0.0_f64;
    for i in 0..one.nrows() {
        for j in 0..one.ncols() {
            let size = (other[(i, i)] * other[(j, j)]).abs().sqrt();
            largest = largest.max((one[(i, j)] - other[(i, j)]).abs() / size);
        }
    }
    largest
}

impl AxialResistance {
    /// The resistance matrix, with the bodies in the caller's order.
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// The resistance matrix by elements of one order less, for error estimates.
    ///
    /// See [`AxialResistance::error_factor`].
    pub fn lower_order(&self) -> &DMatrix<f64> {
        &self.lower_order
    }

    /// Ratio of the estimated error to the last change.
    ///
    /// A quantity computed from both [`AxialResistance::matrix`] and
    /// [`AxialResistance::lower_order`] has an estimated error of this factor times the difference
    /// of the two results.
    pub fn error_factor(&self) -> f64 {
        self.error_factor
    }

    /// The resistance matrix without its estimated error: that of the next orders, extrapolated.
    ///
    /// `R + factor (R - R_lower)`, with [`AxialResistance::error_factor`]. Its own error is a
    /// fraction of the estimated one, which no estimate tells.
    pub fn extrapolated(&self) -> DMatrix<f64> {
        &self.matrix + (&self.matrix - &self.lower_order) * self.error_factor
    }

    /// Estimated discretisation error: the largest of an entry `R_ij`, relative to
    /// `sqrt(R_ii R_jj)`.
    pub fn relative_error(&self) -> f64 {
        self.error_factor * distance(&self.lower_order, &self.matrix)
    }

    /// Number of velocity and pressure degrees of freedom of the last system.
    ///
    /// Those in the interior of triangles and in collars are eliminated before and not counted.
    pub fn dofs(&self) -> usize {
        self.dofs
    }

    /// Polynomial degree of the velocities.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Number of triangles of the mesh.
    pub fn triangles(&self) -> usize {
        self.triangles
    }

    /// Largest true relative residual of a solve.
    pub fn residual(&self) -> f64 {
        self.residual
    }
}
