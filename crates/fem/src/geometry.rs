//! Geometry maps of cells: in closed form for affine cells, at quadrature points for curved ones.

use mesh::{TET_EDGES, Vec3};
use nalgebra::Matrix3;

use crate::error::{FemError, mean_of_vertices};
use crate::quadrature::CellPoint;
use crate::taylor_hood::vertex_gradients;

/// Positions of the ten nodes of a cell.
pub(crate) type CellNodes = [Vec3; 10];

/// Geometry of an affine cell.
#[derive(Clone, Copy)]
pub(crate) struct Affine {
    /// Gradients of the barycentric coordinates times the volume, `|T| ∇l_a`.
    pub scaled_gradients: [Vec3; 4],
    /// Volume `|T|`.
    pub volume: f64,
}

impl Affine {
    /// Straight cell of the first four nodes; an error unless its volume is positive.
    pub fn new(cell: usize, nodes: &CellNodes) -> Result<Self, FemError> {
        let [x0, x1, x2, x3] = [nodes[0], nodes[1], nodes[2], nodes[3]];
        let (a, b, c) = (x1 - x0, x2 - x0, x3 - x0);
        // ∇l_1 = (b × c) / det J and |T| = det J / 6.
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

    /// `g_e = |T| ∇l_a · ∇l_b` for the edges `e = (a, b)` of [`TET_EDGES`].
    pub fn edge_weights(&self) -> [f64; 6] {
        let g = &self.scaled_gradients;
        TET_EDGES.map(|[a, b]| g[a].dot(&g[b]) / self.volume)
    }

    /// Geometry map of the cell; its `measure` is the Jacobian determinant without a weight.
    pub fn map(&self) -> MapAt {
        let [_, g1, g2, g3] = self.scaled_gradients;
        MapAt {
            inverse_transpose: Matrix3::from_columns(&[g1, g2, g3]) / self.volume,
            measure: 6.0 * self.volume,
        }
    }

    /// Geometry map with the quadrature weight of `point`.
    pub fn map_at(&self, point: &CellPoint) -> MapAt {
        let map = self.map();
        MapAt {
            measure: map.measure * point.weight,
            ..map
        }
    }
}

/// Geometry map of a cell at a quadrature point.
pub(crate) struct MapAt {
    /// `J^-T`, which maps reference gradients to physical gradients.
    inverse_transpose: Matrix3<f64>,
    /// Quadrature weight times the Jacobian determinant.
    pub measure: f64,
}

impl MapAt {
    /// Geometry map at `point`; an error unless its Jacobian determinant is positive there.
    #[inline(always)]
    pub fn new(cell: usize, nodes: &CellNodes, point: &CellPoint) -> Result<Self, FemError> {
        // The columns of J are the derivatives of the position with respect to the reference
        // coordinates.
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

    /// `J^-T`, which maps reference gradients to physical gradients.
    pub fn inverse_transpose(&self) -> Matrix3<f64> {
        self.inverse_transpose
    }

    /// Physical gradients of the ten shape functions.
    pub fn gradients(&self, point: &CellPoint) -> [Vec3; 10] {
        point.gradients.map(|g| self.inverse_transpose * g)
    }

    /// Physical gradient `J^-T g` of a function with the reference gradient `g`.
    pub fn physical(&self, reference: &Vec3) -> Vec3 {
        self.inverse_transpose * reference
    }

    /// Physical gradient `∂u_c/∂x_k` of a vector field from its reference gradient `∂u_c/∂ξ_k`.
    pub fn gradient(&self, reference: &Matrix3<f64>) -> Matrix3<f64> {
        reference * self.inverse_transpose.transpose()
    }

    /// Divergence of a vector field from its reference gradient `∂u_c/∂ξ_k`.
    pub fn divergence(&self, reference: &Matrix3<f64>) -> f64 {
        reference.dot(&self.inverse_transpose)
    }

    /// `J^-1 J^-T`: the product of two physical gradients is `g · (J^-1 J^-T) h` for reference
    /// gradients `g` and `h`.
    pub fn metric(&self) -> Matrix3<f64> {
        self.inverse_transpose.tr_mul(&self.inverse_transpose)
    }

    /// `J^-1 v`: its product with a reference gradient is that of `v` with the physical one.
    pub fn pulled_back_vector(&self, vector: &Vec3) -> Vec3 {
        self.inverse_transpose.tr_mul(vector)
    }

    /// `M J^-T`: its product with a reference gradient is that of `M` with the physical one.
    pub fn pulled_back(&self, matrix: &Matrix3<f64>) -> Matrix3<f64> {
        matrix * self.inverse_transpose
    }

    /// Physical gradients of the four barycentric coordinates.
    pub fn vertex_gradients(&self) -> [Vec3; 4] {
        vertex_gradients().map(|g| self.inverse_transpose * g)
    }
}

/// The error for a cell whose Jacobian determinant is not positive.
#[cold]
fn inverted(cell: usize, nodes: &CellNodes, jacobian: f64) -> FemError {
    FemError::InvertedCell {
        cell,
        at: mean_of_vertices(nodes).into(),
        jacobian,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::{degree_2, degree_5};

    /// Nodes of the straight reference tetrahedron.
    fn reference() -> CellNodes {
        let x = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let m = TET_EDGES.map(|[i, j]| 0.5 * (x[i] + x[j]));
        [x[0], x[1], x[2], x[3], m[0], m[1], m[2], m[3], m[4], m[5]]
    }

    #[test]
    fn affine_map_equals_the_map_at_quadrature_points() {
        let nodes =
            reference().map(|x| Vec3::new(x.x + 0.3 * x.y, 2.0 * x.y - x.z, 0.1 * x.x + x.z));
        let affine = Affine::new(0, &nodes).unwrap();
        for point in degree_2() {
            let (closed, at) = (affine.map_at(point), MapAt::new(0, &nodes, point).unwrap());
            assert!((closed.inverse_transpose - at.inverse_transpose).amax() < 1e-14);
            assert!((closed.measure - at.measure).abs() < 1e-15);
        }
        let sum: f64 = degree_5()
            .iter()
            .map(|q| MapAt::new(0, &nodes, q).unwrap().measure)
            .sum();
        assert!((sum - affine.volume).abs() < 1e-15);
    }

    #[test]
    fn inverted_flat_and_non_finite_cells_are_errors() {
        let mirrored = reference().map(|x| Vec3::new(-x.x, x.y, x.z));
        let flat = reference().map(|x| Vec3::new(x.x, x.y, 0.0));
        let nan = reference().map(|x| Vec3::new(f64::NAN, x.y, x.z));
        let huge = reference().map(|x| 1e200 * x);
        for nodes in [mirrored, flat, nan, huge] {
            for result in [
                Affine::new(7, &nodes).map(|_| ()),
                MapAt::new(7, &nodes, &degree_5()[0]).map(|_| ()),
            ] {
                assert!(matches!(
                    result,
                    Err(FemError::InvertedCell { cell: 7, .. })
                ));
            }
        }
    }

    #[test]
    fn a_cell_folded_by_a_displaced_midside_node_is_an_error() {
        let mut nodes = reference();
        nodes[4] = Vec3::new(1.2, 0.0, 0.0);
        assert!(
            degree_5()
                .iter()
                .any(|point| MapAt::new(0, &nodes, point).is_err())
        );
    }
}
