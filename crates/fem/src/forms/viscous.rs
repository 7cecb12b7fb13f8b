//! Full viscous form `∫ 2 D(u):D(v)`, the reference for the scalar stiffness matrix.

use linalg::Csr;
use mesh::{TetMesh, Vec3};
use nalgebra::Matrix3;

use crate::assemble::{Entry, Form};
use crate::geometry::{Affine, CellNodes, MapAt};
use crate::quadrature::{degree_2, degree_5};
use crate::{FemError, TaylorHood};

impl TaylorHood {
    /// Full viscous matrix `∫ 2 D(u):D(v)` with the symmetric gradient `D`.
    ///
    /// For traction boundaries, and as a check of the scalar stiffness matrix. Block `(i, j)` is
    /// `∫ (∇N_i · ∇N_j) I + ∇N_j ∇N_i^T`; its rows are the components of the test function `N_i`.
    ///
    /// Shape: `3 n_points` × `3 n_points`, symmetric; dof `3 j + c` is component `c` at point `j`.
    /// Rigid motions are its null space, to rounding, on affine and on curved cells. The quadrature
    /// is that of [`TaylorHood::stiffness`]. Cost: nine times the memory of the scalar matrix, and
    /// 7.2 kB of temporary memory per curved cell.
    ///
    /// # Errors
    /// [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn viscous_block(&self, mesh: &TetMesh) -> Result<Csr, FemError> {
        let (starts, columns) = (&self.pattern.row_starts, &self.pattern.columns);
        let blocks = self.assemble(mesh, starts, &Viscous)?;
        Ok(interleaved(starts, columns, &blocks))
    }
}

/// Scalar matrix with interleaved components from a matrix of 3 × 3 blocks.
pub(super) fn interleaved(starts: &[usize], columns: &[u32], blocks: &[Matrix3<f64>]) -> Csr {
    let nodes = starts.len() - 1;
    let mut row_starts = vec![0];
    let mut scalar_columns = Vec::with_capacity(9 * columns.len());
    let mut values = Vec::with_capacity(9 * columns.len());
    for i in 0..nodes {
        for c in 0..3 {
            for k in starts[i]..starts[i + 1] {
                scalar_columns.extend([0, 1, 2].map(|d| 3 * columns[k] + d));
                values.extend([0, 1, 2].map(|d| blocks[k][(c, d)]));
            }
            row_starts.push(values.len());
        }
    }
    Csr::new((3 * nodes, 3 * nodes), row_starts, scalar_columns, values)
}

impl Entry for Matrix3<f64> {
    fn add(&mut self, contribution: Self) {
        *self += contribution;
    }
}

struct Viscous;

/// `(a · b) I + b a^T`: block for a test function of gradient `a` and a trial function of gradient
/// `b`.
pub(super) fn pair(a: &Vec3, b: &Vec3) -> Matrix3<f64> {
    b * a.transpose() + Matrix3::from_diagonal_element(a.dot(b))
}

impl Form<10, 10> for Viscous {
    type Entry = Matrix3<f64>;
    type AffineData = Affine;

    fn affine_data(&self, _: usize, affine: &Affine) -> Affine {
        *affine
    }

    fn affine_row(affine: &Affine, local: usize) -> [Matrix3<f64>; 10] {
        let mut row = [Matrix3::zeros(); 10];
        for point in degree_2() {
            let map = affine.map_at(point);
            let gradients = map.gradients(point);
            let weighted = gradients[local] * map.measure;
            for j in 0..10 {
                row[j] += pair(&weighted, &gradients[j]);
            }
        }
        row
    }

    fn curved(&self, cell: usize, nodes: &CellNodes) -> Result<[[Matrix3<f64>; 10]; 10], FemError> {
        let mut blocks = [[Matrix3::zeros(); 10]; 10];
        for point in degree_5() {
            let map = MapAt::new(cell, nodes, point)?;
            let gradients = map.gradients(point);
            for i in 0..10 {
                let weighted = gradients[i] * map.measure;
                for j in 0..10 {
                    blocks[i][j] += pair(&weighted, &gradients[j]);
                }
            }
        }
        Ok(blocks)
    }
}
