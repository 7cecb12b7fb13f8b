//! Closed surfaces of triangles, such as those of files.

mod closed;
mod feature_sizes;
mod moved;
mod patch;
mod self_intersection;
mod sharp_edges;
mod tree;
mod vertex_normals;

use crate::surface::triangles;
use std::sync::Arc;

use crate::GenerateError;
use feature_sizes::FeatureSizes;
use mesh::{Surface, SurfaceMesh, Vec3};
pub use moved::CurvedTriangles;
use patch::{Patch, integrals};
use sharp_edges::SharpEdges;
use tree::{CurveTree, Foot, PatchTree};

/// A closed surface given by triangles, with closest points, volume and feature sizes.
///
/// Smooth surfaces consist of point-normal triangles, cubic patches (Vlachos et al. 2001) through
/// the vertices of the triangles. For vertices on a smooth shape, their distance from it decreases
/// like the fourth power of the edge length where the triangles are regular.
///
/// A clone shares the triangles.
#[derive(Clone)]
pub struct TriangulatedSurface {
    parts: Arc<Parts>,
    /// Own coordinates of a point are `scale (x - origin)`, with its coordinates `x` in the file.
    scale: f64,
    origin: Vec3,
    /// Radius of the ball about `origin` in units of the file.
    radius: f64,
}

/// How the triangles of a surface are understood.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum TriangleKind {
    /// The surface is curved through the vertices: between them it follows the normals that the
    /// triangles give. Edges at which the normals differ by more than 40 degrees are kept sharp.
    #[default]
    Smooth,
    /// The triangles are flat faces. Edges at which the normals differ by more than 5 degrees are
    /// kept; across others, midside nodes lie on the faces and edges of the mesh need not be
    /// theirs.
    Faceted,
}

impl TriangleKind {
    /// Angle between normals above which an edge is sharp, in degrees.
    ///
    /// Forty degrees is between the 30 degrees of coarse, but usable triangulations (twelve
    /// segments around a tube) and the 45 degrees of a chamfer.
    fn sharp_angle(self) -> f64 {
        match self {
            Self::Smooth => 40.0,
            Self::Faceted => 5.0,
        }
    }
}

/// What does not depend on scale and origin.
struct Parts {
    mesh: SurfaceMesh,
    neighbours: Vec<[u32; 3]>,
    kind: TriangleKind,
    edges: SharpEdges,
    patches: Vec<Patch>,
    tree: PatchTree,
    sharp: CurveTree,
    sizes: FeatureSizes,
    volume: f64,
    area: f64,
    centroid: Vec3,
    is_convex: bool,
}

/// A defect of a surface at a triangle, before the name of the surface is known.
struct Defect {
    triangle: usize,
    at: Vec3,
    problem: String,
}

impl Defect {
    fn new(triangle: usize, at: Vec3, problem: impl Into<String>) -> Self {
        Self {
            triangle,
            at,
            problem: problem.into(),
        }
    }

    /// A defect at the centroid of a triangle.
    fn in_middle(mesh: &SurfaceMesh, triangle: usize, problem: impl Into<String>) -> Self {
        Self::new(triangle, triangles::centroid(mesh, triangle), problem)
    }

    /// The error of the surface with this name.
    fn of(self, name: &str) -> GenerateError {
        GenerateError::BadSurface {
            surface: name.into(),
            triangle: self.triangle + 1,
            at: self.at.into(),
            problem: self.problem,
        }
    }
}

impl TriangulatedSurface {
    /// The surface of a triangulation, after all checks; `name` is its name in error messages.
    ///
    /// Own coordinates are those of the triangulation. Cost: some 20 microseconds per triangle.
    ///
    /// # Errors
    /// [`GenerateError::BadSurface`] for triangles that are open, not manifold, not oriented,
    /// inside out, degenerate, folded, in several parts, or that intersect themselves, and for
    /// features below a thousandth of the surface's radius.
    pub fn new(name: &str, mesh: SurfaceMesh, kind: TriangleKind) -> Result<Self, GenerateError> {
        let parts = Parts::new(mesh, kind, None).map_err(|defect| defect.of(name))?;
        Ok(Self::from_parts(parts))
    }

    fn from_parts(parts: Parts) -> Self {
        let origin = Vec3::zeros();
        Self {
            radius: parts.radius_about(&origin),
            parts: Arc::new(parts),
            scale: 1.0,
            origin,
        }
    }

    /// The same surface with the point `origin` of its present coordinates as origin.
    #[must_use]
    pub fn about(&self, origin: Vec3) -> Self {
        let origin = self.origin + origin / self.scale;
        Self {
            radius: self.parts.radius_about(&origin),
            origin,
            ..self.clone()
        }
    }

    /// The same surface, enlarged by `factor` about its origin.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            scale: self.scale * factor,
            ..self.clone()
        }
    }

    /// Centroid of the volume inside.
    pub fn centroid(&self) -> Vec3 {
        self.own(self.parts.centroid)
    }

    /// Area of the surface.
    pub fn area(&self) -> f64 {
        self.parts.area * self.scale.powi(2)
    }

    /// Size of the smooth surface through the vertices over the size of this one with flat faces:
    /// the cube root of the ratio of their volumes.
    ///
    /// The smooth surface is that of [`TriangleKind::Smooth`], with the sharp edges of that kind:
    /// on a sphere its volume has an error of fourth order in the length of edges, that of faces of
    /// second order. To first order in the distance between both, forces on a nearly round body
    /// change like its size. None for a surface that is smooth already.
    pub fn smooth_size(&self) -> Option<f64> {
        let (parts, smooth) = (&self.parts, TriangleKind::Smooth);
        if parts.kind == smooth {
            return None;
        }
        let (mesh, neighbours) = (&parts.mesh, &parts.neighbours);
        let sharp = SharpEdges::find(mesh, neighbours, smooth.sharp_angle()).ok()?;
        let normals = vertex_normals::corner_normals(mesh, neighbours, &sharp);
        let patches = vertex_normals::curved(mesh, &normals, &sharp);
        let volume = integrals(&patches, triangles::centroid(mesh, 0)).volume;
        Some((volume / parts.volume).cbrt())
    }

    /// Number of triangles.
    pub fn n_triangles(&self) -> usize {
        self.parts.mesh.triangles.len()
    }

    /// A point that no point of the surface exceeds in a direction, a unit vector.
    ///
    /// It is on the surface if that is faceted, and leaves it by a fraction of the rise of its
    /// curved triangles otherwise.
    pub fn farthest(&self, direction: Vec3) -> Vec3 {
        self.own(self.parts.tree.farthest(&self.parts.patches, &direction))
    }

    /// Largest distance of the surface from the line through the origin with this direction, a unit
    /// vector, with the same excess as [`farthest`](Self::farthest).
    pub fn largest_distance_from_axis(&self, direction: Vec3) -> f64 {
        let hulls = self.parts.patches.iter().flat_map(Patch::hull);
        let distances = hulls.map(|x| self.own(x).cross(&direction).norm());
        distances.fold(0.0, f64::max)
    }

    /// Own coordinates of a point of the file.
    fn own(&self, x: Vec3) -> Vec3 {
        self.scale * (x - self.origin)
    }

    /// The point of the file with these coordinates.
    fn in_file(&self, x: Vec3) -> Vec3 {
        x / self.scale + self.origin
    }
}

impl Parts {
    /// The neighbours and sharp edges of triangles without defects: all edges with this angle, or
    /// the given ones.
    fn checked(
        mesh: &SurfaceMesh,
        kind: TriangleKind,
        edges: Option<&SharpEdges>,
    ) -> Result<(Vec<[u32; 3]>, SharpEdges), Defect> {
        let neighbours = closed::neighbours_of_closed(mesh)?;
        let mut sharp = SharpEdges::find(mesh, &neighbours, kind.sharp_angle())?;
        if let Some(edges) = edges {
            edges.check_others(mesh, &sharp)?;
            sharp = edges.moved(mesh);
        }
        self_intersection::check(mesh)?;
        Ok((neighbours, sharp))
    }

    fn new(
        mut mesh: SurfaceMesh,
        kind: TriangleKind,
        edges: Option<&SharpEdges>,
    ) -> Result<Self, Defect> {
        let (neighbours, sharp) = Self::checked(&mesh, kind, edges)?;
        mesh.sharp_edges = sharp.pairs(&mesh);
        mesh.corners = sharp.corners.clone();
        let mut normals = vertex_normals::corner_normals(&mesh, &neighbours, &sharp);
        let patches = match kind {
            TriangleKind::Smooth => vertex_normals::curved(&mesh, &normals, &sharp),
            TriangleKind::Faceted => vertex_normals::flat(&mesh),
        };
        if kind == TriangleKind::Faceted {
            // Flat faces have no curvature.
            normals.fill([None; 3]);
        }
        let tree = PatchTree::new(&patches);
        let curves = mesh.triangles.iter().enumerate().flat_map(|(t, triangle)| {
            let is_sharp = sharp.of_triangles[t];
            let patch = patches[t];
            let once = (0..3).filter(|&i| triangle[(i + 1) % 3] < triangle[(i + 2) % 3]);
            let once: Vec<usize> = once.filter(|&i| is_sharp[i]).collect();
            once.into_iter().map(move |i| patch.edge(i))
        });
        let curves = CurveTree::new(curves.collect());
        // Moments about a point near the surface lose no digits.
        let about = triangles::centroid(&mesh, 0);
        let sums = integrals(&patches, about);
        let mut parts = Self {
            neighbours,
            kind,
            edges: sharp,
            tree,
            sharp: curves,
            sizes: FeatureSizes::none(),
            volume: sums.volume,
            area: sums.area,
            centroid: about + sums.moments / sums.volume,
            is_convex: false,
            patches,
            mesh,
        };
        let radius = parts.radius_about(&parts.centroid);
        parts.sizes = FeatureSizes::new(
            &parts.mesh,
            &parts.patches,
            &parts.tree,
            &normals,
            radius,
            &|x| parts.signed_distance(x),
        )?;
        let depth = -parts.signed_distance(&parts.centroid);
        parts.sizes.inradius = parts.sizes.inradius.max(depth);
        parts.is_convex = parts.is_convex(radius);
        Ok(parts)
    }

    /// Radius of a ball about a point that contains all patches.
    fn radius_about(&self, x: &Vec3) -> f64 {
        let patches = self.patches.iter();
        let points = patches.flat_map(|p| match p.bulge {
            0.0 => p.corners.to_vec(),
            _ => p.hull().collect(),
        });
        points.map(|y| (y - x).norm()).fold(0.0, f64::max)
    }

    /// Whether no triangle rises above the plane of a neighbour by more than the rounding of single
    /// precision.
    fn is_convex(&self, radius: f64) -> bool {
        let tolerance = 1e-6 * radius;
        (0..self.mesh.triangles.len()).all(|t| {
            let [a, b, c] = self.patches[t].corners;
            let normal = (b - a).cross(&(c - a)).normalize();
            self.neighbours[t].iter().all(|&u| {
                let corners = self.patches[u as usize].corners;
                corners.iter().all(|x| normal.dot(&(x - a)) <= tolerance)
            })
        })
    }

    fn closest(&self, x: &Vec3) -> Foot {
        let found = self.tree.closest(&self.patches, x, f64::INFINITY, |_| true);
        // Only a point that is not finite has none.
        found.unwrap_or(Foot {
            triangle: 0,
            at: [1.0, 0.0, 0.0],
            point: Vec3::repeat(f64::NAN),
            distance: f64::NAN,
        })
    }

    /// Distance with the sign that the normal at the closest point gives.
    ///
    /// On an edge it is the sum of the normals on both sides, at a vertex the sum around it
    /// weighted by the angles (Baerentzen & Aanaes 2005).
    fn signed_distance(&self, x: &Vec3) -> f64 {
        let foot = self.closest(x);
        let t = foot.triangle;
        let zeros = foot.at.iter().filter(|b| **b == 0.0).count();
        let normal = match zeros {
            0 => self.patches[t].normal(foot.at),
            1 => {
                let i = foot.at.iter().position(|b| *b == 0.0).unwrap_or(0);
                let own = self.patches[t].normal(foot.at);
                let other = self.neighbours[t][i] as usize;
                let mut at = [0.0; 3];
                for k in [(i + 1) % 3, (i + 2) % 3] {
                    let vertex = self.mesh.triangles[t][k];
                    let slot = self.mesh.triangles[other].iter().position(|v| *v == vertex);
                    at[slot.unwrap_or(0)] = foot.at[k];
                }
                own + self.patches[other].normal(at)
            }
            _ => {
                let i = foot.at.iter().position(|b| *b > 0.0).unwrap_or(0);
                let fan = triangles::fan(&self.mesh, &self.neighbours, t, i);
                fan.map(|(t, i)| {
                    let (u, v) = (
                        self.patches[t].edge((i + 2) % 3),
                        self.patches[t].edge((i + 1) % 3),
                    );
                    let (u, v) = (u.points[1] - u.points[0], v.points[2] - v.points[3]);
                    let normal = u.cross(&v);
                    normal.try_normalize(0.0).unwrap_or_default() * normal.norm().atan2(u.dot(&v))
                })
                .sum()
            }
        };
        if normal.dot(&(x - foot.point)) < 0.0 {
            -foot.distance
        } else {
            foot.distance
        }
    }
}

impl Surface for TriangulatedSurface {
    fn signed_distance(&self, point: Vec3) -> f64 {
        self.scale * self.parts.signed_distance(&self.in_file(point))
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        self.own(self.parts.closest(&self.in_file(point)).point)
    }

    fn closest_on_sharp_edges(&self, point: Vec3) -> Option<Vec3> {
        let closest = self.parts.sharp.closest(&self.in_file(point))?;
        Some(self.own(closest))
    }

    /// The ball about the origin of the own coordinates.
    fn bounding_ball(&self) -> (Vec3, f64) {
        (Vec3::zeros(), self.scale * self.radius)
    }

    fn volume(&self) -> f64 {
        self.scale.powi(3) * self.parts.volume
    }

    /// Whether the shape is convex and contains its origin well.
    fn is_convex(&self) -> bool {
        self.parts.is_convex && {
            let depth = -self.parts.signed_distance(&self.origin);
            depth > 0.5 * self.parts.sizes.inradius
        }
    }

    /// Smallest feature size away from sharp edges.
    fn reach(&self) -> f64 {
        self.scale * self.parts.sizes.smallest
    }

    fn inradius(&self) -> f64 {
        self.scale * self.parts.sizes.inradius
    }

    fn curvature_size(&self, point: Vec3, factor: f64, growth: f64) -> f64 {
        self.scale
            * self
                .parts
                .sizes
                .edge_length(&self.in_file(point), factor, growth)
    }

    fn triangulation(&self) -> Option<SurfaceMesh> {
        let mut mesh = self.parts.mesh.clone();
        mesh.points.iter_mut().for_each(|x| *x = self.own(*x));
        Some(mesh)
    }

    fn has_fine_triangulation(&self) -> bool {
        true
    }
}

impl std::fmt::Debug for TriangulatedSurface {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TriangulatedSurface")
            .field("triangles", &self.n_triangles())
            .field("kind", &self.parts.kind)
            .field("scale", &self.scale)
            .field("origin", &self.origin)
            .finish()
    }
}

/// Whether triangles, kind, scale and origin are the same.
impl PartialEq for TriangulatedSurface {
    fn eq(&self, other: &Self) -> bool {
        let same_parts = || {
            let (a, b) = (&self.parts, &other.parts);
            a.kind == b.kind
                && a.mesh.points == b.mesh.points
                && a.mesh.triangles == b.mesh.triangles
        };
        self.scale == other.scale
            && self.origin == other.origin
            && (Arc::ptr_eq(&self.parts, &other.parts) || same_parts())
    }
}
