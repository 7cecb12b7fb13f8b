//! The quadratic tetrahedral mesh on which every crate of the workspace works.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use rayon::prelude::*;

use crate::jacobian::{curved_volume, scaled_jacobian_bound, scaled_jacobian_of_straight_tet};
use crate::{MeshError, Quality, Regions, Surface, SurfaceMesh, TET_EDGES, Vec3};

/// Tags of the boundary parts on the symmetry planes through the origin normal to x, y and z.
///
/// The meshed part of the fluid is where the coordinate is positive.
pub const SYMMETRY_PLANE_TAGS: [&str; 3] = ["mirror-x", "mirror-y", "mirror-z"];

/// Distance of a midside node from the middle of its edge, relative to the edge, above which a part
/// is curved. Midside nodes of straight edges are written with six digits or more.
const CURVED: f64 = 1e-5;

/// Smallest number of cells per parallel task.
const CELLS_PER_TASK: usize = 1024;

/// A face of the fluid's boundary.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Facet {
    /// Three vertices, then the midside nodes of edges 01, 12, 20; ordered so that
    /// `(x1 - x0) × (x2 - x0)` points out of the fluid.
    pub nodes: [u32; 6],
    /// The cell that the face belongs to.
    pub cell: u32,
    /// Index into [`TetMesh::tags`].
    pub tag: u16,
}

/// The part of a mesh that stays the same when its nodes move.
#[derive(Debug, PartialEq)]
pub(crate) struct Topology {
    pub(crate) n_vertices: usize,
    pub(crate) cells: Vec<[u32; 10]>,
    pub(crate) facets: Vec<Facet>,
    pub(crate) tags: Vec<String>,
    pub(crate) regions: Regions,
}

/// A mesh of 10-node (isoparametric quadratic) tetrahedra with named boundary parts.
///
/// Vertices are numbered first (`0..n_vertices`), then midside nodes. A P1 degree of freedom is
/// therefore a vertex number and a P2 degree of freedom a node number (solvers may renumber
/// theirs). In a straight-sided mesh every midside node is the midpoint of its edge. Every mesh is
/// valid: its cells are one-to-one images of the reference tet, and each boundary face has exactly
/// one tag. Clones share the topology.
///
/// Vertices are in reverse Cuthill-McKee order; midside nodes and cells follow their vertices. The
/// nonzeros of a matrix over the nodes then lie near the diagonals of its four vertex/midside
/// blocks.
#[derive(Clone, Debug, PartialEq)]
pub struct TetMesh {
    pub(crate) points: Vec<Vec3>,
    pub(crate) topology: Arc<Topology>,
}

impl TetMesh {
    /// Positions of all nodes: vertices first, then midside nodes.
    pub fn points(&self) -> &[Vec3] {
        &self.points
    }

    /// Number of vertices; nodes `0..n_vertices` are vertices.
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
    /// Cells are positively oriented: `det(x1 - x0, x2 - x0, x3 - x0) > 0`.
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

    /// Named parts of the volume, with the region of each cell; empty if no region is named.
    pub fn regions(&self) -> &Regions {
        &self.topology.regions
    }

    /// Index of the boundary part `name`.
    ///
    /// # Errors
    /// [`MeshError::UnknownTag`] with the names of all parts.
    pub fn tag(&self, name: &str) -> Result<u16, MeshError> {
        find_tag(self.tags(), name)
    }

    /// Nodes on boundary part `tag`, ascending, each once.
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
    ///
    /// # Panics
    /// If there is no such cell, as indexing [`TetMesh::cells`] does.
    pub fn cell_points(&self, cell: usize) -> [Vec3; 10] {
        self.cells()[cell].map(|node| self.points[node as usize])
    }

    /// Positions of the four vertices of a cell.
    ///
    /// # Panics
    /// As [`TetMesh::cell_points`].
    pub fn cell_vertices(&self, cell: usize) -> [Vec3; 4] {
        let [a, b, c, d, ..] = self.cells()[cell];
        [a, b, c, d].map(|node| self.points[node as usize])
    }

    /// Whether the geometry map of a cell is affine: midside nodes at midpoints up to rounding.
    ///
    /// The tolerance is 16 units of rounding of the cell's largest coordinate. A rigid motion of
    /// the nodes (nine multiplications and additions each) leaves a smaller error, and within this
    /// tolerance the affine and the quadratic map cannot be told apart.
    ///
    /// # Panics
    /// As [`TetMesh::cell_points`].
    pub fn is_affine(&self, cell: usize) -> bool {
        let x = self.cell_points(cell);
        let size = x.iter().map(Vec3::amax).fold(0.0, f64::max);
        TET_EDGES.iter().enumerate().all(|(k, &[i, j])| {
            (x[4 + k] - 0.5 * (x[i] + x[j])).amax() <= 16.0 * f64::EPSILON * size
        })
    }

    /// Volume of a (curved) cell, exact up to rounding.
    ///
    /// # Panics
    /// As [`TetMesh::cell_points`].
    pub fn cell_volume(&self, cell: usize) -> f64 {
        curved_volume(&self.cell_points(cell))
    }

    /// Volume of the fluid: the sum of the volumes of the curved cells, exact up to rounding.
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

    /// For each axis, whether the mesh has a symmetry plane normal to it.
    ///
    /// Symmetry planes are the boundary parts with the tags [`SYMMETRY_PLANE_TAGS`].
    pub fn symmetry_planes(&self) -> [bool; 3] {
        SYMMETRY_PLANE_TAGS.map(|name| self.tags().iter().any(|tag| tag == name))
    }

    /// The axis to which the boundary part `tag` is normal, if it is a symmetry plane.
    pub fn symmetry_plane_axis(&self, tag: u16) -> Option<usize> {
        let name = self.tags().get(usize::from(tag))?;
        SYMMETRY_PLANE_TAGS.iter().position(|plane| plane == name)
    }

    /// Whether the boundary part `tag` is a symmetry plane.
    pub fn is_symmetry_plane(&self, tag: u16) -> bool {
        self.symmetry_plane_axis(tag).is_some()
    }

    /// Nodes on symmetry planes, ascending; for each node, the axes to which its planes are normal.
    ///
    /// Cost: one pass over the facets and a sort.
    pub fn nodes_on_symmetry_planes(&self) -> Vec<(u32, [bool; 3])> {
        let mut nodes: BTreeMap<u32, [bool; 3]> = BTreeMap::new();
        for facet in self.facets() {
            if let Some(axis) = self.symmetry_plane_axis(facet.tag) {
                for node in facet.nodes {
                    nodes.entry(node).or_default()[axis] = true;
                }
            }
        }
        nodes.into_iter().collect()
    }

    /// The facets of a boundary part as triangles that face into the fluid: out of a body.
    ///
    /// Facets of a curved part become four triangles each, with their midside nodes as vertices.
    /// The second value is whether the part is curved.
    ///
    /// # Errors
    /// [`MeshError::UnknownTag`].
    pub fn boundary_part(&self, name: &str) -> Result<(SurfaceMesh, bool), MeshError> {
        let tag = self.tag(name)?;
        let facets = || self.facets().iter().filter(|facet| facet.tag == tag);
        let at = |node: u32| self.points()[node as usize];
        let bends = |facet: &Facet| {
            let [a, b, c, ab, bc, ca] = facet.nodes;
            [[a, b, ab], [b, c, bc], [c, a, ca]]
                .into_iter()
                .any(|[a, b, middle]| {
                    let [a, b, middle] = [a, b, middle].map(at);
                    (middle - 0.5 * (a + b)).norm() > CURVED * (b - a).norm()
                })
        };
        let is_curved = facets().any(bends);
        let mut mesh = SurfaceMesh::default();
        let mut numbers = HashMap::new();
        for facet in facets() {
            let [a, b, c, ab, bc, ca] = facet.nodes;
            let triangles = match is_curved {
                true => vec![[a, ca, ab], [ab, bc, b], [ca, c, bc], [ab, ca, bc]],
                false => vec![[a, c, b]],
            };
            mesh.triangles.extend(triangles.into_iter().map(|triangle| {
                triangle.map(|node| {
                    *numbers.entry(node).or_insert_with(|| {
                        mesh.points.push(at(node));
                        mesh.points.len() as u32 - 1
                    })
                })
            }));
        }
        Ok((mesh, is_curved))
    }

    /// Quality of the cells: shape of their straight tets, Jacobian of the curved ones.
    ///
    /// Cost: one pass over the cells, in parallel; bitwise the same for any number of threads.
    pub fn quality(&self) -> Quality {
        Quality::measure(self.n_cells(), |c| {
            (self.cell_vertices(c), self.scaled_jacobian(c))
        })
    }

    /// Scaled Jacobian of one cell: [`scaled_jacobian_bound`] of a curved cell.
    ///
    /// For a straight cell it is 1, or -1 if the cell is inverted, or 0 if it is flat.
    ///
    /// # Panics
    /// If there is no such cell, as indexing [`TetMesh::cells`] does.
    pub fn scaled_jacobian(&self, cell: usize) -> f64 {
        if self.is_affine(cell) {
            scaled_jacobian_of_straight_tet(self.cell_vertices(cell))
        } else {
            scaled_jacobian_bound(&self.cell_points(cell))
        }
    }

    /// Largest ratio of a cell's longest edge to the local gap width, see [`TetMesh::gap_widths`].
    ///
    /// From 1 on, cells are longer than the gap is wide and do not resolve the flow in it, however
    /// good their shape. Zero with fewer than two surfaces. The fluid is inside `wall` and outside
    /// `bodies`. Cost: cells times surfaces, in parallel; the result does not depend on the number
    /// of threads.
    pub fn gap_ratio(&self, bodies: &[&dyn Surface], wall: Option<&dyn Surface>) -> f64 {
        if bodies.len() + usize::from(wall.is_some()) < 2 {
            return 0.0;
        }
        (0..self.n_cells())
            .into_par_iter()
            .with_min_len(CELLS_PER_TASK)
            .map(|cell| {
                let corners = self.cell_vertices(cell);
                let longest = TET_EDGES
                    .iter()
                    .map(|&[i, j]| (corners[i] - corners[j]).norm())
                    .fold(0.0, f64::max);
                longest / self.gap_width(cell, bodies, wall)
            })
            .reduce(|| 0.0, f64::max)
    }

    /// Local gap width at each cell: the sum of the distances from its centroid to the two nearest
    /// surfaces.
    ///
    /// On the line across a gap this sum is the width of the gap. Infinite with fewer than two
    /// surfaces. The fluid is inside `wall` and outside `bodies`. Cost: cells times surfaces, in
    /// parallel; the result does not depend on the number of threads.
    pub fn gap_widths(&self, bodies: &[&dyn Surface], wall: Option<&dyn Surface>) -> Vec<f64> {
        (0..self.n_cells())
            .into_par_iter()
            .with_min_len(CELLS_PER_TASK)
            .map(|cell| self.gap_width(cell, bodies, wall))
            .collect()
    }

    fn gap_width(&self, cell: usize, bodies: &[&dyn Surface], wall: Option<&dyn Surface>) -> f64 {
        let centroid = self.cell_vertices(cell).iter().sum::<Vec3>() / 4.0;
        let to_wall = wall.map(|wall| -wall.signed_distance(centroid));
        let distances = bodies
            .iter()
            .map(|body| body.signed_distance(centroid))
            .chain(to_wall);
        let [first, second] = distances.fold([f64::INFINITY; 2], |[a, b], d| {
            // The centroid of a cell at a curved surface may lie slightly inside the body. A
            // surface without a distance, whose numbers are not finite, leaves no gap.
            let d = d.max(0.0);
            if d < a { [d, a] } else { [a, b.min(d)] }
        });
        first + second
    }
}

/// The name of a boundary part and its true surface.
pub type NamedSurface<'a> = (&'a str, &'a dyn Surface);

/// Index of `name` in `tags`.
///
/// # Errors
/// [`MeshError::UnknownTag`].
pub(crate) fn find_tag(tags: &[String], name: &str) -> Result<u16, MeshError> {
    match tags.iter().position(|tag| tag == name) {
        Some(index) => Ok(index as u16),
        None => Err(MeshError::UnknownTag {
            name: name.into(),
            known: tags.to_vec(),
        }),
    }
}

/// Checks that all coordinates are finite.
///
/// # Errors
/// [`MeshError::NotFinite`] with the first point that has a NaN or infinite coordinate.
pub(crate) fn check_finite(points: &[Vec3]) -> Result<(), MeshError> {
    let bad = |p: &Vec3| p.iter().any(|x| !x.is_finite());
    match points.iter().position(bad) {
        Some(point) => Err(MeshError::NotFinite { point }),
        None => Ok(()),
    }
}
