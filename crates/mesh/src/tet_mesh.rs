//! The quadratic tetrahedral mesh that every crate of the workspace works on.

use std::sync::Arc;

use nalgebra::Vector3;

use crate::quality::curved_volume;
use crate::{MeshError, Surface};

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

/// What stays when nodes move.
#[derive(Debug, PartialEq)]
pub(crate) struct Topology {
    pub(crate) n_vertices: usize,
    pub(crate) cells: Vec<[u32; 10]>,
    pub(crate) facets: Vec<Facet>,
    pub(crate) tags: Vec<String>,
}

/// A mesh of 10-node (isoparametric quadratic) tetrahedra with named boundary parts.
///
/// Points are numbered vertices first (`0..n_vertices`), then midside nodes, so a P1 unknown is a
/// vertex index and a P2 function a point index (solvers may number their unknowns anew). A straight-sided mesh is one whose midside
/// nodes are the midpoints of their edges. Every mesh is valid: its cells are one-to-one images of the reference
/// tet, and each face of their boundary has one tag. Copies share the topology.
///
/// Vertices are in reverse Cuthill-McKee order, midside nodes and cells follow their vertices: matrices over
/// the points have their entries near the diagonal of the four vertex/midside blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct TetMesh {
    pub(crate) points: Vec<Vec3>,
    pub(crate) topology: Arc<Topology>,
}

impl TetMesh {
    /// All nodes: vertices first, then midside nodes.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Number of vertices; points `0..n_vertices` are vertices.
    pub fn n_vertices(&self) -> usize {
        self.topology.n_vertices
    }

    /// Number of nodes, vertices and midside nodes together.
    pub fn n_points(&self) -> usize {
        self.points.len()
    }

    /// Number of cells.
    pub fn n_cells(&self) -> usize {
        self.topology.cells.len()
    }

    /// Node numbers of each cell: four vertices, then the midside nodes of [`TET_EDGES`].
    ///
    /// Positively oriented: `det(x1 - x0, x2 - x0, x3 - x0) > 0`.
    pub fn cells(&self) -> &[[u32; 10]] {
        &self.topology.cells
    }

    /// The boundary faces, oriented out of the fluid, sorted by tag.
    pub fn facets(&self) -> &[Facet] {
        &self.topology.facets
    }

    /// Names of the boundary parts; [`Facet::tag`] indexes this list.
    pub fn tags(&self) -> &[String] {
        &self.topology.tags
    }

    /// The index of the boundary part `name`.
    ///
    /// # Errors
    /// [`MeshError::UnknownTag`] with the names there are.
    pub fn tag(&self, name: &str) -> Result<u16, MeshError> {
        find_tag(self.tags(), name)
    }

    /// The nodes on boundary part `tag`, ascending, each once.
    ///
    /// Cost: one pass over the facets and a sort.
    pub fn nodes_on(&self, tag: u16) -> Vec<u32> {
        let mut nodes: Vec<u32> = self
            .facets()
            .iter()
            .filter(|facet| facet.tag == tag)
            .flat_map(|facet| facet.nodes)
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Positions of the ten nodes of a cell.
    pub fn cell_points(&self, cell: usize) -> [Vec3; 10] {
        self.cells()[cell].map(|node| self.points[node as usize])
    }

    /// Positions of the four vertices of a cell.
    pub fn cell_vertices(&self, cell: usize) -> [Vec3; 4] {
        let [a, b, c, d, ..] = self.cells()[cell];
        [a, b, c, d].map(|node| self.points[node as usize])
    }

    /// Whether the geometry map of a cell is affine: midside nodes at midpoints up to rounding.
    ///
    /// The tolerance is 16 units of rounding of the largest coordinate: a rigid motion of vertices and midside
    /// nodes (nine multiplications and additions each) leaves less, and within it the two maps cannot be told apart.
    pub fn is_affine(&self, cell: usize) -> bool {
        let x = self.cell_points(cell);
        let size = x.iter().map(Vec3::amax).fold(0.0, f64::max);
        TET_EDGES.iter().enumerate().all(|(k, &[i, j])| {
            (x[4 + k] - 0.5 * (x[i] + x[j])).amax() <= 16.0 * f64::EPSILON * size
        })
    }

    /// The volume of a (curved) cell, exact up to rounding.
    pub fn cell_volume(&self, cell: usize) -> f64 {
        curved_volume(&self.cell_points(cell))
    }

    /// The volume of the fluid, exact up to rounding for the curved cells.
    pub fn volume(&self) -> f64 {
        (0..self.n_cells()).map(|cell| self.cell_volume(cell)).sum()
    }

    /// Lowest and highest coordinates of the nodes.
    pub fn bounding_box(&self) -> [Vec3; 2] {
        let far = Vec3::repeat(f64::INFINITY);
        self.points
            .iter()
            .fold([far, -far], |[low, high], p| [low.inf(p), high.sup(p)])
    }

    /// The same mesh with its nodes elsewhere: `points[i]` is the new place of node `i`.
    ///
    /// The topology is shared, not copied. Cost: one Jacobian bound a curved cell, parallel.
    ///
    /// # Errors
    /// [`MeshError::WrongLength`], [`MeshError::NotFinite`]; [`MeshError::InvertedCell`] with the worst cell if the
    /// motion turns one inside out anywhere.
    pub fn with_points(&self, points: Vec<Vec3>) -> Result<Self, MeshError> {
        if points.len() != self.n_points() {
            return Err(MeshError::WrongLength {
                what: "list of moved nodes".into(),
                expected: self.n_points(),
                found: points.len(),
            });
        }
        check_finite(&points)?;
        Self::checked(points, Arc::clone(&self.topology))
    }

    /// The mesh of these parts, if no cell is turned inside out.
    ///
    /// # Errors
    /// [`MeshError::InvertedCell`] with the worst cell.
    pub(crate) fn checked(points: Vec<Vec3>, topology: Arc<Topology>) -> Result<Self, MeshError> {
        let mesh = Self { points, topology };
        mesh.check_jacobians()?;
        Ok(mesh)
    }
}

/// The true surface of a boundary part.
pub type NamedSurface<'a> = (&'a str, &'a dyn Surface);

/// The index of `name` in `tags`.
pub(crate) fn find_tag(tags: &[String], name: &str) -> Result<u16, MeshError> {
    match tags.iter().position(|tag| tag == name) {
        Some(index) => Ok(index as u16),
        None => Err(MeshError::UnknownTag {
            name: name.into(),
            known: tags.to_vec(),
        }),
    }
}

/// That all coordinates are finite.
pub(crate) fn check_finite(points: &[Vec3]) -> Result<(), MeshError> {
    let bad = |p: &Vec3| p.iter().any(|x| !x.is_finite());
    match points.iter().position(bad) {
        Some(point) => Err(MeshError::NotFinite { point }),
        None => Ok(()),
    }
}
