//! Meshes that follow bodies along the axis.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::flow_system::{FlowSystem, centres};
use super::nested_condensation::NestedCondensation;
use crate::AxisymmetricError;
use crate::curve::{BoundaryPart, Point};
use crate::element::Lagrange;
use crate::mesh::MeridianMesh;
use crate::space::Space;

/// Positions of the nodes as functions of the displacements of the bodies.
///
/// Vertices move along the axis by `sum_b ψ_b d_b`, with harmonic functions `ψ_b` that are one on
/// body `b` and zero on the others and at walls, and nodes by the linear interpolant. Straight
/// triangles stay straight, and the curved ones at a body change by its translation only where they
/// touch it. The conductivity is the inverse of the area, so that small triangles move almost
/// rigidly.
pub(crate) struct MeshMotion {
    reference: Vec<Point>,
    /// `ψ_b` at the nodes, for each body.
    weights: Vec<Vec<f64>>,
    /// Corners of the triangles, which are nodes of the same numbers.
    triangles: Vec<[usize; 3]>,
}

impl MeshMotion {
    /// The motion from the mesh of a system, which is the one of zero displacements.
    ///
    /// # Errors
    /// [`AxisymmetricError::SingularElement`], [`AxisymmetricError::NoNodalBasis`].
    pub fn new(system: &FlowSystem, n_bodies: usize) -> Result<Self, AxisymmetricError> {
        let mesh = system.mesh();
        let linear = Lagrange::new(1)?;
        let parts = Space::new(mesh, &linear).parts(mesh, &linear);
        let is_prescribed =
            |v: usize| matches!(parts[v], Some(BoundaryPart::Body(_) | BoundaryPart::Wall));
        let of_corner = |&v: &usize| (!is_prescribed(v)).then_some(v as u32);
        let unknowns = (mesh.triangles.iter())
            .map(|corners| corners.iter().map(of_corner).collect())
            .collect();
        let n = mesh.points.len();
        let condensation = NestedCondensation::new(unknowns, &centres(mesh), n, &[]);
        let stiffness = |t: usize| Ok::<_, AxisymmetricError>(stiffness(mesh, t));
        let factors = Arc::new(condensation).factor(&stiffness)?;
        let weights = (0..n_bodies).map(|body| {
            let on_body = |v: usize| parts[v] == Some(BoundaryPart::Body(body));
            let mut rhs = vec![0.0; n];
            for (t, corners) in mesh.triangles.iter().enumerate() {
                let matrix = self::stiffness(mesh, t);
                for (i, &row) in corners
                    .iter()
                    .enumerate()
                    .filter(|(_, v)| !is_prescribed(**v))
                {
                    for (j, _) in corners.iter().enumerate().filter(|(_, v)| on_body(**v)) {
                        rhs[row] -= matrix[(i, j)];
                    }
                }
            }
            let mut at_vertices = factors.solve(&rhs);
            for v in (0..n).filter(|&v| on_body(v)) {
                at_vertices[v] = 1.0;
            }
            system.linear_at_nodes(&at_vertices)
        });
        Ok(Self {
            reference: system.positions(),
            weights: weights.collect(),
            triangles: mesh.triangles.clone(),
        })
    }

    /// Smallest quality of a triangle relative to its own without displacements; negative if one is
    /// inverted.
    ///
    /// The quality is the area over the sum of the squares of the edges.
    pub fn quality(&self, positions: &[Point]) -> f64 {
        let of = |corners: &[usize; 3], positions: &[Point]| {
            let [a, b, c] = corners.map(|v| positions[v]);
            let [u, v, w] = [b - a, c - b, a - c];
            (b - a).perp(&(c - a)) / (u.norm_squared() + v.norm_squared() + w.norm_squared())
        };
        (self.triangles.iter())
            .map(|corners| of(corners, positions) / of(corners, &self.reference))
            .fold(f64::INFINITY, f64::min)
    }

    /// Positions of the nodes for these displacements of the bodies.
    pub fn positions(&self, displacements: &[f64]) -> Vec<Point> {
        let mut positions = self.reference.clone();
        for (weights, displacement) in self.weights.iter().zip(displacements) {
            for (x, weight) in positions.iter_mut().zip(weights) {
                x.x += weight * displacement;
            }
        }
        positions
    }
}

/// The matrix `∫ ∇φ_i · ∇φ_j / area` of a triangle with straight edges.
fn stiffness(mesh: &MeridianMesh, t: usize) -> DMatrix<f64> {
    let [a, b, c] = mesh.triangles[t].map(|v| mesh.points[v]);
    // the gradient of a corner's function is the opposite edge, turned, over twice the area
    let edges = [c - b, a - c, b - a];
    let double_area = (b - a).perp(&(c - a));
    DMatrix::from_fn(3, 3, |i, j| {
        edges[i].dot(&edges[j]) / (double_area * double_area)
    })
}
