//! `int c (2 D(u):D(v) + lambda div u div v)` on linear elements.

use linalg::Csr;
use mesh::{TetMesh, Vec3};
use nalgebra::Matrix3;

use super::viscous::{interleaved, pair};
use crate::assemble::Form;
use crate::check::check_array;
use crate::geometry::{Affine, CellNodes, MapAt};
use crate::quadrature::degree_5;
use crate::{FemError, TaylorHood};

impl TaylorHood {
    /// The matrix of linear elasticity on linear elements, `int c (2 D(u):D(v) + lame div u div v)` with one coefficient a cell, for
    /// the motion of meshes.
    ///
    /// Shapes: `coefficient` one a cell; result `3 n_vertices` x `3 n_vertices`, unknown `3 j + c` is component `c` at vertex `j`; symmetric.
    /// # Errors
    /// A coefficient of the wrong length or not finite; [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn vertex_elasticity(
        &self,
        mesh: &TetMesh,
        coefficient: &[f64],
        lame: f64,
    ) -> Result<Csr, FemError> {
        check_array("the coefficient", coefficient, mesh.cells().len())?;
        check_array("the Lame parameter", &[lame], 1)?;
        let form = VertexElasticity { coefficient, lame };
        let blocks = self.assemble(mesh, &self.vertex_row_starts, &form)?;
        Ok(interleaved(
            &self.vertex_row_starts,
            &self.vertex_columns,
            &blocks,
        ))
    }
}

struct VertexElasticity<'a> {
    coefficient: &'a [f64],
    lame: f64,
}

/// An affine cell: gradients, what their products are weighed with, and the Lame parameter.
#[derive(Clone, Copy)]
struct Weighted {
    gradients: [Vec3; 4],
    weight: f64,
    lame: f64,
}

/// The block of `v` with gradient `a` and `u` with gradient `b`.
fn block(a: &Vec3, b: &Vec3, lame: f64) -> Matrix3<f64> {
    pair(a, b) + a * (lame * b).transpose()
}

impl Form<4, 4> for VertexElasticity<'_> {
    type Entry = Matrix3<f64>;
    type Shared = Weighted;

    fn share(&self, cell: usize, affine: &Affine) -> Weighted {
        Weighted {
            gradients: affine.scaled_gradients,
            weight: self.coefficient[cell] / affine.volume,
            lame: self.lame,
        }
    }

    fn affine_row(shared: &Weighted, local: usize) -> [Matrix3<f64>; 4] {
        let g = &shared.gradients;
        [0, 1, 2, 3].map(|j| shared.weight * block(&g[local], &g[j], shared.lame))
    }

    fn curved(&self, cell: usize, nodes: &CellNodes) -> Result<[[Matrix3<f64>; 4]; 4], FemError> {
        let mut blocks = [[Matrix3::zeros(); 4]; 4];
        for point in degree_5() {
            let map = MapAt::new(cell, nodes, point)?;
            let gradients = map.vertex_gradients();
            let weight = map.measure * self.coefficient[cell];
            for i in 0..4 {
                for j in 0..4 {
                    blocks[i][j] += weight * block(&gradients[i], &gradients[j], self.lame);
                }
            }
        }
        Ok(blocks)
    }
}
