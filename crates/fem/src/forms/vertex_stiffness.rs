//! Scalar stiffness matrix of linear elements, `∫ c ∇ψ_p · ∇ψ_q`.

use linalg::Csr;
use mesh::{TET_EDGES, TetMesh};

use crate::assemble::{Form, matrix_on_pattern};
use crate::error::check_array;
use crate::geometry::Affine;
use crate::point_values::PointValues;
use crate::{FemError, TaylorHood};

impl TaylorHood {
    /// Scalar stiffness matrix of linear elements on the quadratic geometry, `∫ ∇ψ_p · ∇ψ_q`.
    ///
    /// It equals `I^T K I` with `K` of [`TaylorHood::stiffness`] and `I` of
    /// [`TaylorHood::vertex_interpolation`], because `ψ_q` is a quadratic function too, but it is
    /// assembled directly. Shape: `n_vertices` × `n_vertices`, symmetric.
    ///
    /// # Errors
    /// [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn vertex_stiffness(&self, mesh: &TetMesh) -> Result<Csr, FemError> {
        self.vertex_matrix(
            mesh,
            &VertexStiffness {
                coefficient: |_| 1.0,
            },
        )
    }

    /// Stiffness matrix of linear elements with a coefficient, `∫ c ∇ψ_p · ∇ψ_q`.
    ///
    /// For mesh motion: `coefficient` holds `c`, one value per cell.
    /// Shape: `n_vertices` × `n_vertices`, symmetric.
    ///
    /// # Errors
    /// A coefficient of the wrong length or not finite; [`FemError::OtherMesh`],
    /// [`FemError::InvertedCell`].
    pub fn weighted_vertex_stiffness(
        &self,
        mesh: &TetMesh,
        coefficient: &[f64],
    ) -> Result<Csr, FemError> {
        check_array("the coefficient", coefficient, mesh.cells().len())?;
        self.vertex_matrix(
            mesh,
            &VertexStiffness {
                coefficient: |cell| coefficient[cell],
            },
        )
    }

    /// Assembles a matrix on the linear elements.
    pub(crate) fn vertex_matrix<F: Form<4, 4, Entry = f64>>(
        &self,
        mesh: &TetMesh,
        form: &F,
    ) -> Result<Csr, FemError> {
        let values = self.assemble_form(mesh, &self.vertex_row_starts, form)?;
        let shape = (self.n_vertices(), self.n_vertices());
        let (starts, columns) = (&self.vertex_row_starts, &self.vertex_columns);
        Ok(matrix_on_pattern(shape, starts, columns, values))
    }
}

struct VertexStiffness<C> {
    coefficient: C,
}

impl<C: Fn(usize) -> f64 + Sync> Form<4, 4> for VertexStiffness<C> {
    type Entry = f64;
    type AffineData = [f64; 6];

    fn affine_data(&self, cell: usize, affine: &Affine) -> [f64; 6] {
        let coefficient = (self.coefficient)(cell);
        affine.edge_weights().map(|weight| coefficient * weight)
    }

    fn affine_row(weights: &[f64; 6], local: usize) -> [f64; 4] {
        let mut row = [0.0; 4];
        for (weight, [i, j]) in weights.iter().zip(TET_EDGES) {
            // The row sums are zero, so the diagonal entry is minus the sum of the others.
            if i == local {
                row[j] += weight;
                row[i] -= weight;
            } else if j == local {
                row[i] += weight;
                row[j] -= weight;
            }
        }
        row
    }

    fn add(&self, point: &PointValues<'_>, matrix: &mut [[f64; 4]; 4]) {
        let gradients = &point.linear_gradients();
        let weight = point.weight * (self.coefficient)(point.cell);
        for i in 0..4 {
            for j in 0..4 {
                matrix[i][j] += weight * gradients[i].dot(&gradients[j]);
            }
        }
    }
}
