//! Discrete divergence, `b_qj = -∫ ψ_q ∇N_j`.

use linalg::Csr3;
use mesh::{TET_EDGES, TetMesh, Vec3};

use crate::assemble::{Form, matrix_on_pattern};
use crate::geometry::Affine;
use crate::point_values::PointValues;
use crate::taylor_hood::linear_mass;
use crate::{FemError, TaylorHood};

impl TaylorHood {
    /// Discrete divergence with the sign of the saddle-point system, `b_qj = -∫ ψ_q ∇N_j`.
    ///
    /// The momentum equation is `K u + B^T p = f`, incompressibility `B u = 0`.
    ///
    /// Shape: `n_vertices` × `n_points`, entries are 3-vectors. Exact on affine cells and on curved
    /// cells (there the Jacobian cancels and the integrand is a polynomial of degree 4); hence
    /// `B^T 1 = 0` at interior nodes, and `B u = 0` for constant `u`, to rounding.
    /// Cost per cell and core: about 0.6 μs for an affine cell; 4 μs for a curved cell.
    ///
    /// # Errors
    /// [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn divergence(&self, mesh: &TetMesh) -> Result<Csr3, FemError> {
        let row_starts = &self.pattern.row_starts[..=self.n_vertices()];
        let values = self.assemble_form(mesh, row_starts, &Divergence)?;
        let shape = (self.n_vertices(), self.n_points());
        let columns = &self.pattern.columns[..values.len()];
        Ok(matrix_on_pattern(shape, row_starts, columns, values))
    }
}

struct Divergence;

impl Form<4, 10> for Divergence {
    type Entry = Vec3;
    type AffineData = [Vec3; 4];

    fn affine_data(&self, _: usize, affine: &Affine) -> [Vec3; 4] {
        affine.scaled_gradients
    }

    fn affine_row(g: &[Vec3; 4], q: usize) -> [Vec3; 10] {
        let mut row = [Vec3::zeros(); 10];
        for j in 0..4 {
            // ∇N_j = (4 l_j - 1) ∇l_j, and ∫ ψ_q / |T| = 1/4.
            row[j] = (0.25 - 4.0 * linear_mass(q, j)) * g[j];
        }
        for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
            // ∇N_ij = 4 (l_i ∇l_j + l_j ∇l_i).
            row[4 + k] = -4.0 * (linear_mass(q, i) * g[j] + linear_mass(q, j) * g[i]);
        }
        row
    }

    fn add(&self, point: &PointValues<'_>, matrix: &mut [[Vec3; 10]; 4]) {
        let gradients = point.quadratic_gradients();
        for (row, value) in matrix.iter_mut().zip(point.linear()) {
            let weight = -point.weight * value;
            for (entry, gradient) in row.iter_mut().zip(&gradients) {
                *entry += weight * gradient;
            }
        }
    }
}
