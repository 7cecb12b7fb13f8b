//! The answer: how forces follow from motions.

use nalgebra::{DMatrix, DVector};

/// The grand resistance matrix of spheres, symmetric positive definite, with what a coarser expansion gives.
///
/// Six rows and columns a sphere: force and torque about its centre that it exerts on the fluid, for its velocity and angular
/// velocity; viscosity 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Resistance {
    matrix: DMatrix<f64>,
    coarser: DMatrix<f64>,
    tail: f64,
    dofs: usize,
}

impl Resistance {
    pub(crate) fn new(matrix: DMatrix<f64>, coarser: DMatrix<f64>, tail: f64, dofs: usize) -> Self {
        Self {
            matrix,
            coarser,
            tail,
            dofs,
        }
    }

    /// Number of multipoles on all surfaces.
    pub fn dofs(&self) -> usize {
        self.dofs
    }

    /// The matrix.
    pub fn matrix(&self) -> &DMatrix<f64> {
        &self.matrix
    }

    /// The matrix from expansions of order two less: what is computed from both tells the error, see [`Resistance::tail`].
    pub fn coarser(&self) -> &DMatrix<f64> {
        &self.coarser
    }

    /// The error of anything computed from [`Resistance::matrix`] is estimated as its change from [`Resistance::coarser`] times this.
    pub fn tail(&self) -> f64 {
        self.tail
    }

    /// Estimated error of each entry.
    pub fn error(&self) -> DMatrix<f64> {
        (&self.matrix - &self.coarser).abs() * self.tail
    }

    /// Largest estimated error of an entry $R_{ij}$ relative to $\sqrt{R_{ii} R_{jj}}$.
    pub fn relative_error(&self) -> f64 {
        self.tail * self.relative_difference(&self.coarser)
    }

    /// Largest difference of an entry of another resistance of the same bodies, relative to $\sqrt{R_{ii} R_{jj}}$; infinite for a
    /// matrix of another size.
    pub fn relative_difference(&self, other: &DMatrix<f64>) -> f64 {
        if other.shape() != self.matrix.shape() {
            return f64::INFINITY;
        }
        let difference = (&self.matrix - other).abs();
        let size = |i: usize| self.matrix[(i, i)].sqrt();
        (0..difference.nrows())
            .flat_map(|i| (0..difference.ncols()).map(move |j| (i, j)))
            .map(|(i, j)| difference[(i, j)] / (size(i) * size(j)))
            .fold(0.0, f64::max)
    }

    /// Adds to some rows and columns of the matrix and of the coarser one.
    pub(crate) fn add(&mut self, rows: &[usize], matrix: &DMatrix<f64>, coarser: &DMatrix<f64>) {
        for (i, &row) in rows.iter().enumerate() {
            for (j, &column) in rows.iter().enumerate() {
                self.matrix[(row, column)] += matrix[(i, j)];
                self.coarser[(row, column)] += coarser[(i, j)];
            }
        }
    }

    /// Forces and torques on the fluid for velocities and angular velocities.
    ///
    /// # Panics
    /// When `velocities` has not six entries a sphere.
    pub fn forces(&self, velocities: &DVector<f64>) -> DVector<f64> {
        &self.matrix * velocities
    }
}
