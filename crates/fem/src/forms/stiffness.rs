//! `K_ij = int grad N_i . grad N_j` on quadratic elements.

use linalg::Csr;
use mesh::TetMesh;

use crate::assemble::Form;
use crate::geometry::{Affine, CellNodes, MapAt};
use crate::quadrature::degree_5;
use crate::reference::STIFFNESS_BY_EDGE;
use crate::{FemError, TaylorHood};

impl TaylorHood {
    /// The scalar stiffness matrix of quadratic elements, `K_ij = int grad N_i . grad N_j`, which serves each of the
    /// three velocity components.
    ///
    /// Shape: `n_points` x `n_points`, symmetric; constants are its null space. It stands for `2 D:D` wherever
    /// velocities vanish or are rigid on the boundary, once `2 |B_h| omega . Omega` is added for each turning body.
    /// Affine cells are exact. On curved cells the integrand is rational (degree 6 over the cubic Jacobian) and the
    /// 14-point rule of degree 5 leaves an error of higher order than the element's own.
    /// Cost: about 0.6 us an affine cell and core; 4 us and 800 bytes
    /// of scratch a curved cell.
    /// # Errors
    /// [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn stiffness(&self, mesh: &TetMesh) -> Result<Csr, FemError> {
        let values = self.assemble(mesh, &self.pattern.row_starts, &Stiffness)?;
        Ok(self.on_nodes(values))
    }
}

struct Stiffness;

impl Form<10, 10> for Stiffness {
    type Entry = f64;
    type Shared = [f64; 6];

    fn share(&self, _: usize, affine: &Affine) -> [f64; 6] {
        affine.edge_weights()
    }

    fn affine_row(weights: &[f64; 6], local: usize) -> [f64; 10] {
        let table = &STIFFNESS_BY_EDGE[local];
        let mut row = [0.0; 10];
        for e in 0..6 {
            for j in 0..10 {
                row[j] += weights[e] * table[e][j];
            }
        }
        row
    }

    fn curved(&self, cell: usize, nodes: &CellNodes) -> Result<[[f64; 10]; 10], FemError> {
        let mut k = [[0.0; 10]; 10];
        for point in degree_5() {
            let map = MapAt::new(cell, nodes, point)?;
            let gradients = map.gradients(point);
            for i in 0..10 {
                let weighted = gradients[i] * map.measure;
                for j in i..10 {
                    k[i][j] += weighted.dot(&gradients[j]);
                }
            }
        }
        for i in 0..10 {
            for j in 0..i {
                k[i][j] = k[j][i];
            }
        }
        Ok(k)
    }
}
