//! Resistance matrices with error estimates.

use nalgebra::DMatrix;

use crate::spheroid::AxialSpheroid;
use crate::surface_modes::{self, MODES, SurfaceMode};

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

/// Resistance to motions along the axis and to velocities of the surfaces, with an error estimate.
///
/// The matrix of [`SurfaceResistance::power`] has one row for the velocity of each body, then one
/// row for each [`SurfaceMode`](crate::SurfaceMode) of each body, body by body. It is the bilinear
/// form of the power: with the amplitudes `q` the forces on the fluid that are conjugate to them
/// are the product with `q`, and those of the first rows are the forces of the bodies along the
/// axis. Viscosity 1.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceResistance {
    power: AxialResistance,
    powers_in_flows: DMatrix<f64>,
}

impl SurfaceResistance {
    pub(crate) fn new(power: AxialResistance, bodies: &[AxialSpheroid]) -> Self {
        let n = bodies.len();
        let mut powers_in_flows = DMatrix::zeros(n * (1 + MODES), n * (1 + MODES));
        for (i, body) in bodies.iter().enumerate() {
            let first = n + MODES * i;
            let mut own = powers_in_flows.fixed_view_mut::<MODES, MODES>(first, first);
            own.copy_from(&surface_modes::powers_in_flows(body));
        }
        Self {
            power,
            powers_in_flows,
        }
    }

    /// The matrix of the power, with its error estimate.
    pub fn power(&self) -> &AxialResistance {
        &self.power
    }

    /// Powers `∮ u_i · 2 E_j n dS` of modes `i` in the viscous stress of the flows `j`, extension
    /// and parabola, with the normal out of the body; same rows and columns.
    pub fn powers_in_flows(&self) -> &DMatrix<f64> {
        &self.powers_in_flows
    }

    /// Row of a mode of a body.
    pub fn row(&self, body: usize, mode: SurfaceMode) -> usize {
        let bodies = self.power.matrix.nrows() / (1 + MODES);
        bodies + MODES * body + mode as usize
    }
}
