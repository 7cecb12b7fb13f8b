//! The vertices of a mesh during its generation, with the body or container to which each belongs.

use super::hill_climbing::MidsideOffsets;
use super::packing::{is_near, pack};
use super::size_field::SizeField;
use super::symmetry_planes::SymmetryPlanes;
use crate::GenerateError;
use crate::delaunay::{FlipRules, circumcentre, insertion_order};
use crate::surface::triangles;
use mesh::{Surface, SurfaceMesh, TET_EDGES, Vec3};
use std::collections::{HashSet, VecDeque};
use std::ops::Range;

/// Height of a regular tet over its edge.
const TET_HEIGHT: f64 = 0.816_496_580_927_726;

/// Owner of a vertex inside the fluid.
const FLUID: u32 = u32::MAX;

/// The surface of a body or container, with the triangles by which it is meshed.
pub(crate) struct Part<'a> {
    pub surface: &'a dyn Surface,
    pub mesh: SurfaceMesh,
    /// Whether the mesh must have exactly these triangles as faces.
    pub is_given: bool,
}

/// The vertices of a mesh during its generation.
pub(crate) struct Layout<'a> {
    /// Positions.
    pub points: Vec<Vec3>,
    /// Whether a vertex may move.
    pub free: Vec<bool>,
    /// Owner of each vertex: the body that has it on its surface or at its centre.
    ///
    /// `bodies.len()` for the container, [`FLUID`] inside the fluid.
    pub owner: Vec<u32>,
    /// Vertices on each body, then on the container.
    pub vertices: Vec<Range<u32>>,
    /// Designed triangles of each body, then of the container.
    pub triangles: Vec<Vec<[u32; 3]>>,
    /// For each of them its number in the triangulation before symmetry planes cut it.
    pub designed: Vec<Vec<usize>>,
    /// Sharp edges of all surfaces, the smaller vertex first.
    pub sharp: HashSet<[u32; 2]>,
    /// Vertices at the centres of convex bodies; they are not part of the final mesh.
    pub centres: Range<u32>,
    /// Symmetry planes, which cut off all negative coordinates.
    pub planes: SymmetryPlanes,
    /// For each body, then for the container, whether its triangles are given.
    pub is_given: Vec<bool>,
    /// Offsets of the midside nodes of given triangles, where they are not zero.
    pub given_offsets: MidsideOffsets,
    surfaces: Vec<&'a dyn Surface>,
    container: &'a dyn Surface,
    /// What the tets with all vertices on the container can be.
    pub wall: WallKind,
}

/// What the tets with all vertices on the container can be.
#[derive(Clone, Copy)]
pub(crate) enum WallKind {
    /// All of them are in the fluid.
    Hull,
    /// Some are flat, because the curvature of the wall is discontinuous.
    CurvatureJumps,
    /// Some are flat or outside.
    AnyShape,
}

impl<'a> Layout<'a> {
    /// Places the vertices of the bodies and, last of the `parts`, the container, then the centres
    /// of convex bodies, then the fluid.
    ///
    /// # Errors
    /// [`GenerateError::TooManyVertices`].
    pub fn new(
        parts: Vec<Part<'a>>,
        planes: SymmetryPlanes,
        field: &SizeField<'_>,
        limit: usize,
    ) -> Result<Self, GenerateError> {
        let mut surfaces: Vec<&dyn Surface> = parts.iter().map(|part| part.surface).collect();
        let Some(container) = surfaces.pop() else {
            return Err(mesh::MeshError::Empty.into());
        };
        let mut layout = Layout {
            points: Vec::new(),
            free: Vec::new(),
            owner: Vec::new(),
            vertices: Vec::new(),
            triangles: Vec::new(),
            designed: Vec::new(),
            sharp: HashSet::new(),
            centres: 0..0,
            planes,
            is_given: parts.iter().map(|part| part.is_given).collect(),
            given_offsets: MidsideOffsets::new(),
            surfaces,
            container,
            wall: WallKind::Hull,
        };
        let mut seeds = Vec::new();
        for (k, Part { mesh, .. }) in parts.into_iter().enumerate() {
            let side = if k == layout.surfaces.len() {
                -1.0
            } else {
                1.0
            };
            seeds.extend(apexes(&mesh, side, field));
            let (mesh, designed) = planes.cut(mesh);
            layout.designed.push(designed);
            let first = layout.points.len() as u32;
            let sharp = mesh.sharp_edges.iter();
            layout
                .sharp
                .extend(sharp.map(|edge| edge.map(|v| v + first)));
            layout.triangles.push(
                mesh.triangles
                    .iter()
                    .map(|t| t.map(|v| v + first))
                    .collect(),
            );
            layout.add(&mesh.points, k as u32, false);
            layout.vertices.push(first..layout.points.len() as u32);
        }
        let (surfaces, known) = (&layout.surfaces, &layout.points);
        let packed = pack(field, surfaces, container, planes, known, &seeds, limit)?;
        let first_centre = layout.points.len() as u32;
        for k in 0..layout.surfaces.len() {
            if layout.surfaces[k].is_convex() {
                layout.add(&[layout.surfaces[k].centre()], k as u32, false);
            }
        }
        layout.centres = first_centre..layout.points.len() as u32;
        // Along a space-filling curve neighbours in the mesh are neighbours in memory.
        let ordered: Vec<Vec3> = insertion_order(&packed)
            .into_iter()
            .map(|i| packed[i as usize])
            .collect();
        layout.add(&ordered, FLUID, true);
        Ok(layout)
    }

    fn add(&mut self, points: &[Vec3], owner: u32, free: bool) {
        self.points.extend_from_slice(points);
        self.owner.resize(self.points.len(), owner);
        self.free.resize(self.points.len(), free);
    }

    /// The longest edge of a tet between different parts, or through the fluid between vertices of
    /// one part; `boundary` has the edges of boundary faces, smaller numbers first.
    ///
    /// Where a surface is concave, a tet may have all vertices on it, and two faces that the curved
    /// surface joins smoothly.
    pub fn longest_inner_edge(
        &self,
        tet: &[u32; 4],
        boundary: &HashSet<[u32; 2]>,
    ) -> Option<[u32; 2]> {
        let owner = |v: u32| self.owner[v as usize];
        let length = |[a, b]: &[u32; 2]| {
            let [a, b] = [a, b].map(|v| self.points[*v as usize]);
            (b - a).norm()
        };
        let edges = TET_EDGES.map(|[i, j]| [tet[i], tet[j]]);
        (edges.into_iter())
            .filter(|&[a, b]| {
                let is_inside = owner(a) != FLUID && !boundary.contains(&[a.min(b), a.max(b)]);
                owner(a) != owner(b) || is_inside
            })
            .max_by(|x, y| length(x).total_cmp(&length(y)))
    }

    /// Adds a free vertex in the middle of an edge; returns its number.
    pub fn divide(&mut self, [a, b]: [u32; 2]) -> u32 {
        let middle = 0.5 * (self.points[a as usize] + self.points[b as usize]);
        self.add(&[middle], FLUID, true);
        self.points.len() as u32 - 1
    }

    /// Removes vertices inside the fluid, given in ascending order.
    pub fn remove(&mut self, vertices: &[usize]) {
        let mut is_kept = vec![true; self.points.len()];
        vertices.iter().for_each(|&v| is_kept[v] = false);
        let kept = |v: &usize| is_kept[*v];
        let all = 0..self.points.len();
        self.points = all.clone().filter(kept).map(|v| self.points[v]).collect();
        self.owner = all.clone().filter(kept).map(|v| self.owner[v]).collect();
        self.free = all.filter(kept).map(|v| self.free[v]).collect();
    }

    /// Offsets of the midside nodes of boundary edges from the midpoints.
    pub fn midside_offsets(&self, boundary: &[[u32; 3]]) -> MidsideOffsets {
        let mut offsets = self.given_offsets.clone();
        for &[a, b, c] in boundary {
            let owner = self.owner[a as usize] as usize;
            let surface = self.surfaces.get(owner).unwrap_or(&self.container);
            let is_given = self.is_given.get(owner) == Some(&true);
            let is_flat = self.plane_of([a, b, c]).is_some();
            for [i, j] in [[a, b], [b, c], [c, a]] {
                let [at, to] = [i, j].map(|v| self.points[v as usize]);
                // Each edge belongs to two faces with opposite directions; at a symmetry plane one
                // of them is flat.
                if is_given {
                    continue;
                }
                if !is_flat && (i < j || !self.planes.through(&[at, to]).is_empty()) {
                    let middle = 0.5 * (at + to);
                    offsets.insert([i.min(j), i.max(j)], surface.closest_point(middle) - middle);
                }
            }
        }
        offsets
    }

    /// The axis to which a face is normal, if it lies on a symmetry plane.
    pub fn plane_of(&self, face: [u32; 3]) -> Option<usize> {
        let corners = face.map(|v| self.points[v as usize]);
        self.planes.through(&corners).axis()
    }

    /// Whether a tet is in the fluid.
    ///
    /// Others are the tets inside bodies, those outside a container that is not the convex hull of
    /// its vertices, and flat tets on a wall with discontinuous curvature.
    ///
    /// On such a wall, as at the ends of a cylinder, four vertices may lie nearly on a circle, and
    /// the Delaunay tet between them is nearly flat. Without it the wall follows the other
    /// diagonal.
    pub fn is_fluid(&self, tet: &[u32; 4]) -> bool {
        let n_bodies = self.surfaces.len() as u32;
        let owner = tet.map(|v| self.owner[v as usize]);
        if owner[0] < n_bodies {
            let joins = owner.iter().any(|&o| o != owner[0]);
            return joins || self.is_given[owner[0] as usize] || !self.is_inside(tet);
        }
        if owner.iter().any(|&o| o != n_bodies) {
            return true;
        }
        match self.wall {
            _ if self.is_given[owner[0] as usize] => true,
            WallKind::Hull => true,
            WallKind::CurvatureJumps => !is_flat(self.corners(tet)),
            WallKind::AnyShape => {
                let corners = self.corners(tet);
                !is_in_surface(self.container, corners) && is_behind(self.container, corners)
            }
        }
    }

    /// Whether a tet with all vertices on one body is inside it.
    ///
    /// Outside a shape that is not convex are tets between parts of its surface. Their
    /// circumcentres are outside too: the faces whose Delaunay balls have centres on both sides are
    /// the restricted Delaunay triangulation of the surface. Flat tets lie in the surface and only
    /// exchange the diagonal between two of its triangles, so they are on the side where they are
    /// not meshed.
    fn is_inside(&self, tet: &[u32; 4]) -> bool {
        let surface = self.surfaces[self.owner[tet[0] as usize] as usize];
        let corners = self.corners(tet);
        surface.is_convex() || is_in_surface(surface, corners) || is_behind(surface, corners)
    }

    fn corners(&self, tet: &[u32; 4]) -> [Vec3; 4] {
        tet.map(|v| self.points[v as usize])
    }

    /// New position of vertex `i` on its way to a target, with the wanted edge length there.
    ///
    /// The vertex stays, with its length `size`, if it is not free or would come too close to a
    /// surface. Vertices on symmetry planes move in them: by symmetry, the mean over the tets on
    /// both sides of a plane is the mean over one side minus its normal component.
    pub fn moved(&self, i: usize, to: Vec3, size: f64, field: &SizeField<'_>) -> (Vec3, f64) {
        let from = self.points[i];
        if !self.free[i] {
            return (from, size);
        }
        let own = self.planes.at(from);
        let to = own.along(to);
        let h = field.at(to);
        let clear = 0.4 * h;
        let near = self.planes.distance(to, own) < clear
            || !self.container.contains_ball(to, clear)
            || self.surfaces.iter().any(|s| is_near(*s, to, clear));
        if near { (from, size) } else { (to, h) }
    }

    /// The given triangles, with normals out of the fluid.
    pub fn given_faces(&self) -> Vec<[u32; 3]> {
        let given = (0..self.is_given.len()).filter(|&part| self.is_given[part]);
        given
            .flat_map(|part| {
                let is_body = part < self.surfaces.len();
                let outwards = move |&[a, b, c]: &[u32; 3]| match is_body {
                    true => [a, c, b],
                    false => [a, b, c],
                };
                self.triangles[part].iter().map(outwards)
            })
            .collect()
    }
}

impl FlipRules for Layout<'_> {
    /// Tets with all vertices on one surface may fold the curved cells at it.
    fn allows(&self, tet: &[u32; 4]) -> bool {
        let owner = tet.map(|v| self.owner[v as usize]);
        owner[0] == FLUID || owner.iter().any(|&o| o != owner[0])
    }

    fn exchanges_diagonal(&self, quadrilateral: &[u32; 4]) -> bool {
        let mut parts = quadrilateral.iter().map(|&v| self.owner[v as usize]);
        parts.all(|part| self.is_given.get(part as usize) != Some(&true))
    }
}

/// Apexes of nearly regular tets on the triangles, `side` 1 on the outer side and -1 on the inner
/// one.
///
/// They are ordered from neighbour to neighbour, so that the packing accepts about every other one.
fn apexes(mesh: &SurfaceMesh, side: f64, field: &SizeField<'_>) -> Vec<Vec3> {
    let neighbours = triangles::neighbours(mesh);
    let mut seen = vec![false; mesh.triangles.len()];
    let mut queue = VecDeque::new();
    let mut apexes = Vec::with_capacity(seen.len());
    // A surface may have several separate components.
    for first in 0..mesh.triangles.len() {
        if !std::mem::replace(&mut seen[first], true) {
            queue.push_back(first);
        }
        while let Some(t) = queue.pop_front() {
            let [a, b, c] = mesh.triangles[t].map(|v| mesh.points[v as usize]);
            let normal = (b - a).cross(&(c - a)).normalize();
            let centroid = (a + b + c) / 3.0;
            apexes.push(centroid + (side * TET_HEIGHT * field.at(centroid)) * normal);
            for &n in &neighbours[t] {
                if !std::mem::replace(&mut seen[n as usize], true) {
                    queue.push_back(n as usize);
                }
            }
        }
    }
    apexes
}

/// Ratio of volume to cubed longest edge below which a tet is flat.
///
/// A regular tet has 0.118; four vertices of a wall whose edges are 0.4 of its radius of curvature
/// have at most 0.02.
const FLAT_VOLUME: f64 = 0.03;

/// Whether the volume of a tet is far below that of a regular tet with its longest edge.
pub(super) fn is_flat([a, b, c, d]: [Vec3; 4]) -> bool {
    let volume = (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0;
    let edges = [b - a, c - a, d - a, c - b, d - b, d - c];
    let longest = edges.iter().fold(0.0, |m: f64, e| m.max(e.norm()));
    volume < FLAT_VOLUME * longest.powi(3)
}

/// Largest distance of the middle of an edge of a tet that lies in a curved surface from the
/// surface, as a fraction of its length.
///
/// Edges of one radius of curvature, the longest on any surface, rise by 0.13 of their length. An
/// edge between the two sides of a right angle is 0.2 or more away in its middle.
const RISE: f64 = 0.15;

/// Whether a tet with all vertices on a surface lies in it, and only exchanges the diagonal between
/// two of its triangles.
///
/// Such a tet is flat. Beside a sharp edge there are flat tets that do not lie in the surface, with
/// edges from one of its sides to the other.
fn is_in_surface(surface: &dyn Surface, corners: [Vec3; 4]) -> bool {
    if !is_flat(corners) {
        return false;
    }
    let is_sharp = surface.closest_on_sharp_edges(corners[0]).is_some();
    let follows = |[i, j]: [usize; 2]| {
        let (a, b) = (corners[i], corners[j]);
        surface.signed_distance(0.5 * (a + b)).abs() <= RISE * (b - a).norm()
    };
    !is_sharp || TET_EDGES.into_iter().all(follows)
}

/// Whether a tet with all vertices on a surface that is not convex is inside the shape.
///
/// Its circumcentre is on the same side of the surface as the tet, if the surface is smooth. At a
/// sharp edge it may be on the other side, but all of the tet is on one side.
fn is_behind(surface: &dyn Surface, corners: [Vec3; 4]) -> bool {
    let centroid = corners.iter().sum::<Vec3>() / 4.0;
    let point = match surface.closest_on_sharp_edges(centroid) {
        Some(_) => centroid,
        None => circumcentre(corners).0,
    };
    surface.signed_distance(point) < 0.0
}
