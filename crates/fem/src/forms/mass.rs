//! Mass matrices: `∫ ψ_p ψ_q` on linear and `∫ N_i N_j` on quadratic elements.

use linalg::Csr;
use mesh::TetMesh;

use crate::assemble::Form;
use crate::geometry::Affine;
use crate::point_values::PointValues;
use crate::quadrature::{CellPoint, degree_6};
use crate::taylor_hood::{QUADRATIC_MASS, linear_mass};
use crate::{FemError, TaylorHood};

impl TaylorHood {
    /// Mass matrix of the pressure, `∫ ψ_p ψ_q`.
    ///
    /// Shape: `n_vertices` × `n_vertices`, symmetric positive definite; the sum of its entries is
    /// the volume. Exact on affine and on curved cells (degree 5).
    ///
    /// # Errors
    /// [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn pressure_mass(&self, mesh: &TetMesh) -> Result<Csr, FemError> {
        self.vertex_matrix(mesh, &LinearMass)
    }

    /// Scalar mass matrix of quadratic elements, `∫ N_i N_j`.
    ///
    /// Shape: `n_points` × `n_points`, symmetric positive definite. Exact on affine cells. On
    /// curved cells the integrand has degree 7 and the 24-point rule degree 6; its error is of
    /// higher order than the discretisation error.
    ///
    /// # Errors
    /// [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn velocity_mass(&self, mesh: &TetMesh) -> Result<Csr, FemError> {
        let values = self.assemble_form(mesh, &self.pattern.row_starts, &QuadraticMass)?;
        Ok(self.node_matrix(values))
    }
}

struct LinearMass;

impl Form<4, 4> for LinearMass {
    type Entry = f64;
    type AffineData = f64;

    fn affine_data(&self, _: usize, affine: &Affine) -> f64 {
        affine.volume
    }

    fn affine_row(volume: &f64, local: usize) -> [f64; 4] {
        std::array::from_fn(|j| volume * linear_mass(local, j))
    }

    fn add(&self, point: &PointValues<'_>, matrix: &mut [[f64; 4]; 4]) {
        add_products(point.linear(), point.weight, matrix);
    }
}

struct QuadraticMass;

impl Form<10, 10> for QuadraticMass {
    type Entry = f64;
    type AffineData = f64;

    fn affine_data(&self, _: usize, affine: &Affine) -> f64 {
        affine.volume
    }

    fn affine_row(volume: &f64, local: usize) -> [f64; 10] {
        QUADRATIC_MASS[local].map(|entry| volume * entry)
    }

    fn rule(&self, _: bool) -> &'static [CellPoint] {
        degree_6()
    }

    fn add(&self, point: &PointValues<'_>, matrix: &mut [[f64; 10]; 10]) {
        add_products(point.quadratic(), point.weight, matrix);
    }
}

/// Adds `weight N_i N_j`.
fn add_products<const N: usize>(values: &[f64; N], weight: f64, matrix: &mut [[f64; N]; N]) {
    for i in 0..N {
        for j in 0..N {
            matrix[i][j] += weight * (values[i] * values[j]);
        }
    }
}
