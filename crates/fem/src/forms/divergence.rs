//! `b_qj = -int psi_q grad N_j`.

use linalg::Csr3;
use mesh::{TET_EDGES, TetMesh, Vec3};

use crate::assemble::{Form, on_pattern};
use crate::geometry::{Affine, CellNodes, MapAt};
use crate::quadrature::degree_5;
use crate::reference::linear_mass;
use crate::{FemError, TaylorHood};

impl TaylorHood {
    /// The discrete divergence with the sign of the saddle system, `b_qj = -int psi_q grad N_j`, so that momentum
    /// reads `K u + B^T p = f` and incompressibility `B u = 0`.
    ///
    /// Shape: `n_vertices` x `n_points`, entries 3-vectors. Exact on affine and on curved cells (there the integrand
    /// is a polynomial of degree 4, for the Jacobian cancels); hence `B^T 1 = 0` at inner nodes and `B u` of a
    /// constant `u` is zero to rounding.
    /// Cost: about 0.6 us an affine cell and core; 4 us and 960 bytes of scratch a curved cell.
    /// # Errors
    /// [`FemError::OtherMesh`], [`FemError::InvertedCell`].
    pub fn divergence(&self, mesh: &TetMesh) -> Result<Csr3, FemError> {
        let row_starts = &self.pattern.row_starts[..=self.n_vertices()];
        let values = self.assemble(mesh, row_starts, &Divergence)?;
        let shape = (self.n_vertices(), self.n_points());
        let columns = &self.pattern.columns[..values.len()];
        Ok(on_pattern(shape, row_starts, columns, values))
    }
}

struct Divergence;

impl Form<4, 10> for Divergence {
    type Entry = [f64; 3];
    type Shared = [Vec3; 4];

    fn share(&self, _: usize, affine: &Affine) -> [Vec3; 4] {
        affine.scaled_gradients
    }

    fn affine_row(g: &[Vec3; 4], q: usize) -> [[f64; 3]; 10] {
        let mut row = [[0.0; 3]; 10];
        for j in 0..4 {
            // grad N_j = (4 l_j - 1) grad l_j, and int psi_q / |T| = 1/4.
            row[j] = ((0.25 - 4.0 * linear_mass(q, j)) * g[j]).into();
        }
        for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
            // grad N_ij = 4 (l_i grad l_j + l_j grad l_i).
            row[4 + k] = (-4.0 * (linear_mass(q, i) * g[j] + linear_mass(q, j) * g[i])).into();
        }
        row
    }

    fn curved(&self, cell: usize, nodes: &CellNodes) -> Result<[[[f64; 3]; 10]; 4], FemError> {
        let mut b = [[[0.0; 3]; 10]; 4];
        for point in degree_5() {
            let map = MapAt::new(cell, nodes, point)?;
            let gradients = map.gradients(point);
            for q in 0..4 {
                let weight = -map.measure * point.barycentric[q];
                for j in 0..10 {
                    for c in 0..3 {
                        b[q][j][c] += weight * gradients[j][c];
                    }
                }
            }
        }
        Ok(b)
    }
}
