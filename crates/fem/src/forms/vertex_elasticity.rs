//! Elasticity on linear elements, `∫ c (2 D(u):D(v) + λ ∇·u ∇·v)`.

use linalg::Csr;
use mesh::{TetMesh, Vec3};
use nalgebra::Matrix3;

use super::viscous::pair;
use crate::assemble::Form;
use crate::error::check_array;
use crate::geometry::Affine;
use crate::point_values::PointValues;
use crate::weak_form::interleaved_rows;
use crate::{FemError, TaylorHood};

impl TaylorHood {
    /// Matrix of linear elasticity on linear elements, `∫ c (2 D(u):D(v) + λ ∇·u ∇·v)`.
    ///
    /// For mesh motion: `coefficient` holds `c`, one value per cell, and `lame` is `λ`.
    ///
    /// Shape: `3 n_vertices` × `3 n_vertices`, symmetric; dof `3 j + k` is component `k` at vertex
    /// `j`.
    ///
    /// # Errors
    /// A coefficient of the wrong length or not finite; [`FemError::OtherMesh`],
    /// [`FemError::InvertedCell`].
    pub fn vertex_elasticity(
        &self,
        mesh: &TetMesh,
        coefficient: &[f64],
        lame: f64,
    ) -> Result<Csr, FemError> {
        check_array("the coefficient", coefficient, mesh.cells().len())?;
        check_array("the Lamé parameter", &[lame], 1)?;
        let form = VertexElasticity { coefficient, lame };
        let blocks = self.assemble_form(mesh, &self.vertex_row_starts, &form)?;
        let shape = (3 * self.n_vertices(), 3 * self.n_vertices());
        let (starts, columns) = (&self.vertex_row_starts, &self.vertex_columns);
        Ok(interleaved_rows(shape, starts, columns, &blocks))
    }
}

struct VertexElasticity<'a> {
    coefficient: &'a [f64],
    lame: f64,
}

/// Data of an affine cell: gradients, the weight of their products, and the Lamé parameter.
#[derive(Clone, Copy)]
struct Weighted {
    gradients: [Vec3; 4],
    weight: f64,
    lame: f64,
}

/// Block for a test function of gradient `a` and a trial function of gradient `b`.
fn block(a: &Vec3, b: &Vec3, lame: f64) -> Matrix3<f64> {
    pair(a, b) + a * (lame * b).transpose()
}

impl Form<4, 4> for VertexElasticity<'_> {
    type Entry = Matrix3<f64>;
    type AffineData = Weighted;

    fn affine_data(&self, cell: usize, affine: &Affine) -> Weighted {
        Weighted {
            gradients: affine.scaled_gradients,
            weight: self.coefficient[cell] / affine.volume,
            lame: self.lame,
        }
    }

    fn affine_row(data: &Weighted, local: usize) -> [Matrix3<f64>; 4] {
        let g = &data.gradients;
        [0, 1, 2, 3].map(|j| data.weight * block(&g[local], &g[j], data.lame))
    }

    fn add(&self, point: &PointValues<'_>, matrix: &mut [[Matrix3<f64>; 4]; 4]) {
        let gradients = &point.linear_gradients();
        let weight = point.weight * self.coefficient[point.cell];
        for i in 0..4 {
            for j in 0..4 {
                matrix[i][j] += weight * block(&gradients[i], &gradients[j], self.lame);
            }
        }
    }
}
