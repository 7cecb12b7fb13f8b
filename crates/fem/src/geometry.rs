//! Geometry of cells: affine ones in closed form, curved ones point by point.

use mesh::{TET_EDGES, Vec3};
use nalgebra::Matrix3;

use crate::FemError;
use crate::quadrature::CellPoint;
use crate::reference::vertex_gradients;

/// The ten node positions of a cell.
pub(crate) type CellNodes = [Vec3; 10];

/// An affine cell.
#[derive(Clone, Copy)]
pub(crate) struct Affine {
    /// `|T| grad l_a`, the gradients of the barycentric coordinates times the volume.
    pub scaled_gradients: [Vec3; 4],
    /// `|T|`.
    pub volume: f64,
}

impl Affine {
    /// The straight cell of the four vertices; an error unless its volume is positive.
    pub fn new(cell: usize, nodes: &CellNodes) -> Result<Self, FemError> {
        let [x0, x1, x2, x3] = [nodes[0], nodes[1], nodes[2], nodes[3]];
        let (a, b, c) = (x1 - x0, x2 - x0, x3 - x0);
        // grad l_1 = (b x c) / det and |T| = det / 6.
        let (g1, g2, g3) = (b.cross(&c) / 6.0, c.cross(&a) / 6.0, a.cross(&b) / 6.0);
        let volume = g1.dot(&a);
        if !(volume > 0.0 && volume.is_finite()) {
            return Err(inverted(cell, nodes, 6.0 * volume));
        }
        Ok(Self {
            scaled_gradients: [-(g1 + g2 + g3), g1, g2, g3],
            volume,
        })
    }

    /// `g_e = |T| grad l_a . grad l_b` for the edges of [`TET_EDGES`].
    pub fn edge_weights(&self) -> [f64; 6] {
        let g = &self.scaled_gradients;
        TET_EDGES.map(|[a, b]| g[a].dot(&g[b]) / self.volume)
    }

    /// The geometry map at `point`, the same everywhere but for the weight.
    pub fn map_at(&self, point: &CellPoint) -> MapAt {
        let [_, g1, g2, g3] = self.scaled_gradients;
        MapAt {
            inverse_transpose: Matrix3::from_columns(&[g1, g2, g3]) / self.volume,
            measure: 6.0 * self.volume * point.weight,
        }
    }
}

/// The geometry map of a cell at one quadrature point.
pub(crate) struct MapAt {
    /// Inverse transposed Jacobian: takes reference gradients to physical ones.
    inverse_transpose: Matrix3<f64>,
    /// Quadrature weight times Jacobian determinant.
    pub measure: f64,
}

impl MapAt {
    /// The map at `point`; an error unless its Jacobian is positive there.
    pub fn new(cell: usize, nodes: &CellNodes, point: &CellPoint) -> Result<Self, FemError> {
        // Columns of the Jacobian J: derivatives of the position by the reference coordinates.
        let (mut a, mut b, mut c) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
        for (x, g) in nodes.iter().zip(&point.gradients) {
            a += x * g.x;
            b += x * g.y;
            c += x * g.z;
        }
        let bc = b.cross(&c);
        let determinant = a.dot(&bc);
        if !(determinant > 0.0 && determinant.is_finite()) {
            return Err(inverted(cell, nodes, determinant));
        }
        let cofactors = Matrix3::from_columns(&[bc, c.cross(&a), a.cross(&b)]);
        Ok(Self {
            inverse_transpose: cofactors / determinant,
            measure: point.weight * determinant,
        })
    }

    /// Physical gradients of the ten shape functions.
    pub fn gradients(&self, point: &CellPoint) -> [Vec3; 10] {
        point.gradients.map(|g| self.inverse_transpose * g)
    }

    /// Physical gradients of the four barycentric coordinates.
    pub fn vertex_gradients(&self) -> [Vec3; 4] {
        vertex_gradients().map(|g| self.inverse_transpose * g)
    }
}

fn inverted(cell: usize, nodes: &CellNodes, jacobian: f64) -> FemError {
    let at = (nodes[0] + nodes[1] + nodes[2] + nodes[3]) / 4.0;
    FemError::InvertedCell {
        cell,
        at: at.into(),
        jacobian,
    }
}
