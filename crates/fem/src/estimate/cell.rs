//! One cell: bubbles against a quadratic velocity and a linear pressure.

use std::sync::LazyLock;

use mesh::{TetMesh, Vec3};
use nalgebra::Matrix3;

use super::bubbles::{PER_CELL, POINTS, integrals, rule};
use crate::FemError;
use crate::geometry::{Affine, CellNodes, MapAt};
use crate::load::velocity_gradient;
use crate::quadrature::CellPoint;
use crate::reference::shape_gradients;

/// The geometry of a cell.
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

/// A quadratic velocity on a cell.
pub(super) struct CellFlow<'a> {
    shape: Shape,
    nodes: &'a [u32; 10],
    /// Derivatives `(c, k) -> d u_c / d xi_k` by the reference coordinates at the four vertices; linear between them.
    slopes: [Matrix3<f64>; 4],
}

impl<'a> CellFlow<'a> {
    /// The velocity's part on a cell.
    pub fn new(mesh: &'a TetMesh, cell: usize, velocity: &[f64]) -> Result<Self, FemError> {
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
            slopes: AT_VERTICES
                .each_ref()
                .map(|gradients| velocity_gradient(nodes, velocity, gradients)),
        })
    }

    /// A cell for what concerns its bubbles alone: the velocity is zero.
    pub fn of_bubbles(mesh: &'a TetMesh, cell: usize) -> Result<Self, FemError> {
        Ok(Self {
            shape: Shape::new(mesh, cell)?,
            nodes: &mesh.cells()[cell],
            slopes: [Matrix3::zeros(); 4],
        })
    }

    /// Energies $\int |\nabla\phi_k|^2$ of the cell's bubbles.
    pub fn bubble_energies(&self) -> Result<[f64; PER_CELL], FemError> {
        if let Shape::Affine(affine) = &self.shape {
            let map = affine.map();
            let metric = map.metric() * map.measure;
            return Ok(integrals().squares.map(|square| metric.dot(&square)));
        }
        let mut energies = [0.0; PER_CELL];
        for point in rule() {
            let map = self.shape.at(point.at)?;
            for (energy, g) in energies.iter_mut().zip(&point.gradients) {
                *energy += map.measure * map.physical(g).norm_squared();
            }
        }
        Ok(energies)
    }

    fn slope(&self, point: &CellPoint) -> Matrix3<f64> {
        let l = &point.barycentric;
        self.slopes[0] * l[0]
            + self.slopes[1] * l[1]
            + self.slopes[2] * l[2]
            + self.slopes[3] * l[3]
    }

    /// Residuals of momentum $-\int (\nabla u - p 1) \nabla\phi_k$ for a pressure.
    pub fn residuals(&self, pressure: &[f64]) -> Result<[Vec3; PER_CELL], FemError> {
        let p: [f64; 4] = std::array::from_fn(|m| pressure[self.nodes[m] as usize]);
        let mut sums = [Vec3::zeros(); PER_CELL];
        if let Shape::Affine(affine) = &self.shape {
            // The stress is linear: its values at the vertices and the bubbles' moments tell all.
            let map = affine.map();
            for m in 0..4 {
                let stress = map.gradient(&self.slopes[m]) - Matrix3::from_diagonal_element(p[m]);
                let pulled = map.pulled_back(&stress) * -map.measure;
                for (sum, moments) in sums.iter_mut().zip(&integrals().moments) {
                    *sum += pulled * moments[m];
                }
            }
            return Ok(sums);
        }
        for point in rule() {
            let map = self.shape.at(point.at)?;
            let p: f64 = (0..4).map(|m| point.at.barycentric[m] * p[m]).sum();
            let stress = map.gradient(&self.slope(point.at)) - Matrix3::from_diagonal_element(p);
            let pulled = map.pulled_back(&stress) * -map.measure;
            for (sum, g) in sums.iter_mut().zip(&point.gradients) {
                *sum += pulled * g;
            }
        }
        Ok(sums)
    }

    /// Divergence of the velocity with bubbles added, and the measures, at the quadrature points.
    pub fn divergence(
        &self,
        bubbles: &[Vec3; PER_CELL],
    ) -> Result<([f64; POINTS], [f64; POINTS]), FemError> {
        let (mut values, mut measures) = ([0.0; POINTS], [0.0; POINTS]);
        if let Shape::Affine(affine) = &self.shape {
            let map = affine.map();
            let own = self.slopes.each_ref().map(|slope| map.divergence(slope));
            let pulled = bubbles.map(|c| map.pulled_back_vector(&c));
            for (q, point) in rule().iter().enumerate() {
                values[q] = (0..4).map(|m| point.at.barycentric[m] * own[m]).sum();
                for (c, g) in pulled.iter().zip(&point.gradients) {
                    values[q] += c.dot(g);
                }
                measures[q] = map.measure * point.at.weight;
            }
            return Ok((values, measures));
        }
        for (q, point) in rule().iter().enumerate() {
            let map = self.shape.at(point.at)?;
            let mut slope = self.slope(point.at);
            for (c, g) in bubbles.iter().zip(&point.gradients) {
                slope += c * g.transpose();
            }
            values[q] = map.divergence(&slope);
            measures[q] = map.measure;
        }
        Ok((values, measures))
    }

    /// $\int \delta \nabla\phi_k$ for values of $\delta$ at the quadrature points, times the roots of their measures.
    pub fn against_gradients(
        &self,
        weighted: &[f64; POINTS],
    ) -> Result<[Vec3; PER_CELL], FemError> {
        let mut sums = [Vec3::zeros(); PER_CELL];
        for (point, delta) in rule().iter().zip(weighted) {
            let map = self.shape.at(point.at)?;
            let weight = delta * map.measure.sqrt();
            for (sum, g) in sums.iter_mut().zip(&point.gradients) {
                *sum += weight * map.physical(g);
            }
        }
        Ok(sums)
    }

    /// $-\int (\nabla v + \delta 1) \nabla N_a$ for the ten nodes and $\int l_b \nabla\cdot v$ for the four vertices, with `v` given by
    /// its bubbles and $\delta$ as in [`CellFlow::against_gradients`].
    pub fn functional(
        &self,
        bubbles: &[Vec3; PER_CELL],
        weighted: &[f64; POINTS],
    ) -> Result<([Vec3; 10], [f64; 4]), FemError> {
        let (mut velocity, mut pressure) = ([Vec3::zeros(); 10], [0.0; 4]);
        for (point, delta) in rule().iter().zip(weighted) {
            let map = self.shape.at(point.at)?;
            let mut slope = Matrix3::zeros();
            for (c, g) in bubbles.iter().zip(&point.gradients) {
                slope += c * g.transpose();
            }
            let gradient = map.gradient(&slope);
            let divergence = gradient.trace() * map.measure;
            for (sum, l) in pressure.iter_mut().zip(&point.at.barycentric) {
                *sum += l * divergence;
            }
            let stress =
                gradient * map.measure + Matrix3::from_diagonal_element(delta * map.measure.sqrt());
            let pulled = map.pulled_back(&stress);
            for (sum, g) in velocity.iter_mut().zip(&point.at.gradients) {
                *sum -= pulled * g;
            }
        }
        Ok((velocity, pressure))
    }
}

/// Sum of the products of values at the quadrature points.
pub(super) fn dot(a: &[f64; POINTS], b: &[f64; POINTS]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::LinearTets;

    #[test]
    fn the_short_cuts_of_affine_cells_agree_with_quadrature() {
        let mesh = TetMesh::straight(LinearTets::cube(2)).unwrap();
        let velocity: Vec<f64> = (0..3 * mesh.n_points()).map(|i| (i as f64).sin()).collect();
        let pressure: Vec<f64> = (0..mesh.n_vertices()).map(|i| (i as f64).cos()).collect();
        let bubbles = std::array::from_fn(|k| Vec3::new(1.0, k as f64, 0.5 - k as f64));
        for cell in 0..mesh.n_cells() {
            let short = CellFlow::new(&mesh, cell, &velocity).unwrap();
            let long = CellFlow {
                shape: Shape::Curved(cell, mesh.cell_points(cell)),
                ..CellFlow::new(&mesh, cell, &velocity).unwrap()
            };
            let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
            let energies = [&short, &long].map(|flow| flow.bubble_energies().unwrap());
            let residuals = [&short, &long].map(|flow| flow.residuals(&pressure).unwrap());
            let divergences = [&short, &long].map(|flow| flow.divergence(&bubbles).unwrap());
            for k in 0..PER_CELL {
                close(energies[0][k], energies[1][k]);
                close((residuals[0][k] - residuals[1][k]).norm(), 0.0);
            }
            for q in 0..POINTS {
                close(divergences[0].0[q], divergences[1].0[q]);
                close(divergences[0].1[q], divergences[1].1[q]);
            }
        }
    }
}
