//! Integrals of bubbles, a quadratic velocity and a linear pressure over one cell.

use std::sync::LazyLock;

use mesh::{TetMesh, Vec3};
use nalgebra::Matrix3;

use super::bubbles::{BUBBLES_PER_CELL, RULE_POINTS, integrals, rule};
use crate::FemError;
use crate::geometry::{Affine, CellNodes, MapAt};
use crate::quadrature::CellPoint;
use crate::quantity::gradient_in_cell;
use crate::taylor_hood::shape_gradients;

/// Stress at a quadrature point of a cell with this velocity gradient.
type StressAt<'a> = &'a dyn Fn(usize, &Matrix3<f64>) -> Matrix3<f64>;

/// Geometry of a cell.
enum Shape {
    Affine(Affine),
    Curved(usize, CellNodes),
}

impl Shape {
    fn new(mesh: &TetMesh, cell: usize) -> Result<Self, FemError> {
        let positions = mesh.cell_points(cell);
        Ok(if mesh.is_affine(cell) {
            Self::Affine(Affine::new(cell, &positions)?)
        } else {
            Self::Curved(cell, positions)
        })
    }

    fn at(&self, point: &CellPoint) -> Result<MapAt, FemError> {
        match self {
            Self::Affine(affine) => Ok(affine.map_at(point)),
            Self::Curved(cell, positions) => MapAt::new(*cell, positions, point),
        }
    }
}

/// Quadratic velocity on a cell.
pub(super) struct CellFlow<'a> {
    shape: Shape,
    nodes: &'a [u32; 10],
    /// Gradients `∂u_c/∂ξ_k` in reference coordinates at the four vertices; they vary linearly.
    vertex_gradients: [Matrix3<f64>; 4],
}

impl<'a> CellFlow<'a> {
    /// The velocity on a cell.
    pub fn new(mesh: &'a TetMesh, cell: usize, velocity: &[Vec3]) -> Result<Self, FemError> {
        static AT_VERTICES: LazyLock<[[Vec3; 10]; 4]> = LazyLock::new(|| {
            std::array::from_fn(|vertex| {
                let mut l = [0.0; 4];
                l[vertex] = 1.0;
                shape_gradients(l)
            })
        });
        let nodes = &mesh.cells()[cell];
        Ok(Self {
            shape: Shape::new(mesh, cell)?,
            nodes,
            vertex_gradients: AT_VERTICES
                .each_ref()
                .map(|gradients| gradient_in_cell(nodes, velocity, gradients)),
        })
    }

    /// Energies `∫ |∇φ_k|^2` of the bubbles of the cell.
    pub fn bubble_energies(&self) -> Result<[f64; BUBBLES_PER_CELL], FemError> {
        if let Shape::Affine(affine) = &self.shape {
            let map = affine.map();
            let metric = map.metric() * map.measure;
            return Ok(integrals().squares.map(|square| metric.dot(&square)));
        }
        let mut energies = [0.0; BUBBLES_PER_CELL];
        for point in rule() {
            let map = self.shape.at(point.at)?;
            for (energy, g) in energies.iter_mut().zip(&point.gradients) {
                *energy += map.measure * map.physical(g).norm_squared();
            }
        }
        Ok(energies)
    }

    /// Velocity gradient in reference coordinates at a quadrature point.
    fn gradient(&self, point: &CellPoint) -> Matrix3<f64> {
        let l = &point.barycentric;
        self.vertex_gradients[0] * l[0]
            + self.vertex_gradients[1] * l[1]
            + self.vertex_gradients[2] * l[2]
            + self.vertex_gradients[3] * l[3]
    }

    /// Residuals of the momentum equation, `-∫ (∇u - p I) ∇φ_k`; `stress(q, ∇u)` at the points of
    /// the rule stands for `∇u` if it is given.
    pub fn residuals(
        &self,
        pressure: &[f64],
        stress: Option<StressAt>,
    ) -> Result<[Vec3; BUBBLES_PER_CELL], FemError> {
        let p: [f64; 4] = std::array::from_fn(|m| pressure[self.nodes[m] as usize]);
        let mut sums = [Vec3::zeros(); BUBBLES_PER_CELL];
        if let (Shape::Affine(affine), None) = (&self.shape, stress) {
            // The stress is linear, so its vertex values and the moments of the bubbles suffice.
            let map = affine.map();
            for m in 0..4 {
                let stress =
                    map.gradient(&self.vertex_gradients[m]) - Matrix3::from_diagonal_element(p[m]);
                let pulled = map.pulled_back(&stress) * -map.measure;
                for (sum, moments) in sums.iter_mut().zip(&integrals().moments) {
                    *sum += pulled * moments[m];
                }
            }
            return Ok(sums);
        }
        for (q, point) in rule().iter().enumerate() {
            let map = self.shape.at(point.at)?;
            let p: f64 = (0..4).map(|m| point.at.barycentric[m] * p[m]).sum();
            let gradient = map.gradient(&self.gradient(point.at));
            let viscous = stress.map_or(gradient, |stress| stress(q, &gradient));
            let stress = viscous - Matrix3::from_diagonal_element(p);
            let pulled = map.pulled_back(&stress) * -map.measure;
            for (sum, g) in sums.iter_mut().zip(&point.gradients) {
                *sum += pulled * g;
            }
        }
        Ok(sums)
    }

    /// Divergence of the velocity plus bubbles at the quadrature points, and their measures.
    ///
    /// `bubbles` holds the coefficients of the bubbles.
    pub fn divergence(
        &self,
        bubbles: &[Vec3; BUBBLES_PER_CELL],
    ) -> Result<([f64; RULE_POINTS], [f64; RULE_POINTS]), FemError> {
        let (mut values, mut measures) = ([0.0; RULE_POINTS], [0.0; RULE_POINTS]);
        if let Shape::Affine(affine) = &self.shape {
            let map = affine.map();
            let divergences = self.vertex_gradients.each_ref().map(|g| map.divergence(g));
            let pulled = bubbles.map(|c| map.pulled_back_vector(&c));
            for (q, point) in rule().iter().enumerate() {
                values[q] = (0..4)
                    .map(|m| point.at.barycentric[m] * divergences[m])
                    .sum();
                for (c, g) in pulled.iter().zip(&point.gradients) {
                    values[q] += c.dot(g);
                }
                measures[q] = map.measure * point.at.weight;
            }
            return Ok((values, measures));
        }
        for (q, point) in rule().iter().enumerate() {
            let map = self.shape.at(point.at)?;
            let mut gradient = self.gradient(point.at);
            for (c, g) in bubbles.iter().zip(&point.gradients) {
                gradient += c * g.transpose();
            }
            values[q] = map.divergence(&gradient);
            measures[q] = map.measure;
        }
        Ok((values, measures))
    }
}

/// Dot product of values at the quadrature points.
pub(super) fn dot(a: &[f64; RULE_POINTS], b: &[f64; RULE_POINTS]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::LinearTets;

    #[test]
    fn closed_forms_of_affine_cells_equal_quadrature() {
        let mesh = TetMesh::straight(LinearTets::cube(2)).unwrap();
        let velocity: Vec<Vec3> = (0..mesh.n_points())
            .map(|i| Vec3::from_fn(|c, _| ((3 * i + c) as f64).sin()))
            .collect();
        let pressure: Vec<f64> = (0..mesh.n_vertices()).map(|i| (i as f64).cos()).collect();
        let bubbles = std::array::from_fn(|k| Vec3::new(1.0, k as f64, 0.5 - k as f64));
        for cell in 0..mesh.n_cells() {
            let closed = CellFlow::new(&mesh, cell, &velocity).unwrap();
            let quadrature = CellFlow {
                shape: Shape::Curved(cell, mesh.cell_points(cell)),
                ..CellFlow::new(&mesh, cell, &velocity).unwrap()
            };
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
            let energies = [&closed, &quadrature].map(|flow| flow.bubble_energies().unwrap());
            let residuals =
                [&closed, &quadrature].map(|flow| flow.residuals(&pressure, None).unwrap());
            let divergences = [&closed, &quadrature].map(|flow| flow.divergence(&bubbles).unwrap());
            for k in 0..BUBBLES_PER_CELL {
                close(energies[0][k], energies[1][k]);
                close((residuals[0][k] - residuals[1][k]).norm(), 0.0);
            }
            for q in 0..RULE_POINTS {
                close(divergences[0].0[q], divergences[1].0[q]);
                close(divergences[0].1[q], divergences[1].1[q]);
            }
        }
    }
}
