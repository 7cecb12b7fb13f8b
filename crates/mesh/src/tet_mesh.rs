//! The quadratic tetrahedral mesh that every crate of the workspace works on.

use nalgebra::Vector3;

/// A point or a displacement in space.
pub type Vec3 = Vector3<f64>;

/// The local vertex pairs whose midside nodes are local nodes 4..10 (VTK order of `VTK_QUADRATIC_TETRA`).
pub const TET_EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]];

/// A face of the fluid's boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facet {
    /// Three vertices, then the midside nodes of edges 01, 12, 20; ordered so that
    /// `(x1 - x0) x (x2 - x0)` points out of the fluid.
    pub nodes: [u32; 6],
    /// The cell that the face belongs to.
    pub cell: u32,
    /// Index into [`TetMesh::tags`].
    pub tag: u16,
}

/// A mesh of 10-node (isoparametric quadratic) tetrahedra with named boundary parts.
///
/// Points are numbered vertices first (`0..n_vertices`), then midside nodes, so a P1 unknown is a
/// vertex index and a P2 unknown is a point index. A straight-sided mesh is one whose midside
/// nodes are the midpoints of their edges.
#[derive(Clone, Debug, PartialEq)]
pub struct TetMesh {
    pub(crate) points: Vec<Vec3>,
    pub(crate) n_vertices: usize,
    pub(crate) cells: Vec<[u32; 10]>,
    pub(crate) facets: Vec<Facet>,
    pub(crate) tags: Vec<String>,
}

impl TetMesh {
    /// All nodes: vertices first, then midside nodes.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Number of vertices; points `0..n_vertices` are vertices.
    pub fn n_vertices(&self) -> usize {
        self.n_vertices
    }

    /// Number of nodes, vertices and midside nodes together.
    pub fn n_points(&self) -> usize {
        self.points.len()
    }

    /// Node numbers of each cell: four vertices, then the midside nodes of [`TET_EDGES`].
    pub fn cells(&self) -> &[[u32; 10]] {
        &self.cells
    }

    /// The boundary faces, oriented out of the fluid.
    pub fn facets(&self) -> &[Facet] {
        &self.facets
    }

    /// Names of the boundary parts; [`Facet::tag`] indexes this list.
    pub fn tags(&self) -> &[String] {
        &self.tags
    }
}
