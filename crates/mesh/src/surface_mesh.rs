//! Triangulated surfaces.

use crate::Vec3;

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
