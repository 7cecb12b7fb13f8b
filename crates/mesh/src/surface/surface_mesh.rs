//! Triangulated surfaces.

use crate::Vec3;
use std::collections::HashMap;

/// A closed triangulated surface; triangles are counterclockwise as seen from outside the shape.
#[derive(Clone, Debug, Default)]
pub struct SurfaceMesh {
    /// Vertices.
    pub points: Vec<Vec3>,
    /// Vertex numbers of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Sharp edges, which are kept when the triangulation is refined; empty for smooth shapes.
    pub sharp_edges: Vec<[u32; 2]>,
    /// Vertices at which sharp edges end, meet or turn; they stay where they are.
    pub corners: Vec<u32>,
}

impl SurfaceMesh {
    /// For each triangle, the neighbours across the edges opposite its three vertices.
    pub(crate) fn neighbours(&self) -> Vec<[u32; 3]> {
        let mut left = HashMap::new();
        for (t, tri) in self.triangles.iter().enumerate() {
            for i in 0..3 {
                left.insert((tri[(i + 1) % 3], tri[(i + 2) % 3]), t as u32);
            }
        }
        self.triangles
            .iter()
            .map(|tri| [0, 1, 2].map(|i| left[&(tri[(i + 2) % 3], tri[(i + 1) % 3])]))
            .collect()
    }

    /// The same triangulation about another centre, with offsets from the centre rounded to `grid`.
    pub(crate) fn translated(&self, from: Vec3, to: Vec3, grid: f64) -> Self {
        let points = self
            .points
            .iter()
            .map(|p| to + (p - from).map(|c| (c / grid).round() * grid))
            .collect();
        SurfaceMesh {
            points,
            ..self.clone()
        }
    }
}

/// Euler characteristic `V - E + F` of triangles: 2 for a sphere, 0 for a torus, 1 for a disc.
pub(crate) fn euler_characteristic(triangles: &[[u32; 3]]) -> isize {
    let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    vertices.len() as isize - edges.len() as isize + triangles.len() as isize
}
