//! All vertices of a mesh in the making, and whose they are.

use super::capsule_mesh::triangulate_capsule;
use super::climb::Bulges;
use super::packing::{is_near, pack};
use super::planes::Planes;
use super::size::SizeField;
use super::surface_mesh::{SurfaceMesh, triangulate, triangulate_box};
use super::verify::boundary_faces;
use super::{Container, GenerateParams, MeshedBody};
use crate::delaunay::insertion_order;
use crate::{MeshError, Surface, Vec3};
use std::collections::{HashSet, VecDeque};
use std::ops::Range;

/// Height of a regular tet over its edge.
const TET_HEIGHT: f64 = 0.816_496_580_927_726;

/// Volume over the third power of the longest edge below which a tet is flat: a regular one has 0.118, and four vertices of a wall
/// with edges of 0.4 of its radius of curvature have at most 0.02.
const FLAT: f64 = 0.03;

/// Owner of a vertex of the fluid.
const FLUID: u32 = u32::MAX;

pub(super) struct Layout<'a> {
    pub points: Vec<Vec3>,
    /// Whether a vertex may move.
    pub free: Vec<bool>,
    /// The body that has this vertex on its surface or at its centre; `bodies.len()` for the container.
    pub owner: Vec<u32>,
    /// Vertices of each body, then of the container.
    pub vertices: Vec<Range<u32>>,
    /// Their designed triangles.
    pub triangles: Vec<Vec<[u32; 3]>>,
    /// Vertices that are centres of bodies, not of the fluid.
    pub centres: Range<u32>,
    /// What cuts all this off where coordinates are negative.
    pub planes: Planes,
    surfaces: Vec<&'a dyn Surface>,
    container: &'a dyn Surface,
    /// Whether the curvature of the container jumps.
    jumps: bool,
}

/// Checks the numbers and names of the input.
///
/// # Errors
/// A length, coefficient or name that makes no sense.
pub(super) fn check(
    bodies: &[MeshedBody<'_>],
    container: &Container,
    params: &GenerateParams,
) -> Result<(), MeshError> {
    let demand = |ok: bool, what: &str, value: f64, need: &'static str| {
        if ok {
            Ok(())
        } else {
            Err(MeshError::BadParameter {
                what: what.into(),
                value,
                need,
            })
        }
    };
    let length = |what: &str, value: f64| {
        demand(
            value > 0.0 && value.is_finite(),
            what,
            value,
            "it must be positive and finite",
        )
    };
    demand(
        params.growth > 0.0 && params.growth <= 0.6,
        "growth",
        params.growth,
        "it must be above 0 and at most 0.6",
    )?;
    length("gap coefficient", params.gap)?;
    length("least gap", params.min_gap)?;
    demand(
        params.max_size > 0.0,
        "largest size",
        params.max_size,
        "it must be positive",
    )?;
    demand(
        (0.0..60.0).contains(&params.target_dihedral),
        "target dihedral angle",
        params.target_dihedral,
        "it must be at least 0 and below 60 degrees",
    )?;
    let finite = |what: &str, x: Vec3| {
        x.iter()
            .try_for_each(|&c| demand(c.is_finite(), what, c, "it must be finite"))
    };
    match container {
        Container::Ball(ball) => {
            finite("centre of the container", ball.centre)?;
            length("radius of the container", ball.radius)?;
        }
        Container::Box(sides) => {
            finite("corner of the container", sides.min)?;
            finite("corner of the container", sides.max)?;
            for side in (sides.max - sides.min).iter() {
                length("side of the container", *side)?;
            }
        }
        Container::Capsule(capsule) => {
            finite("centre of the container", capsule.centre)?;
            length("radius of the container", capsule.radius)?;
            length("length of the container", capsule.half_length)?;
        }
    }
    let mut names = HashSet::from([Container::TAG]);
    for body in bodies {
        if !names.insert(body.name) {
            return Err(MeshError::BadTag {
                name: body.name.into(),
                problem: "is used twice; give every body its own name",
            });
        }
        let (centre, radius) = body.surface.bounding_ball();
        finite(&format!("position of '{}'", body.name), centre)?;
        length(&format!("radius of '{}'", body.name), radius)?;
        length(&format!("size of '{}'", body.name), body.size)?;
        length(
            &format!("radius of curvature of '{}'", body.name),
            body.surface.smallest_curvature_radius(),
        )?;
    }
    Planes(params.symmetry_planes).check(bodies, container)
}

impl<'a> Layout<'a> {
    /// Places all vertices: surfaces first, then centres of bodies, then the fluid.
    ///
    /// # Errors
    /// Too many vertices.
    pub fn new(
        bodies: &[MeshedBody<'a>],
        container: &'a Container,
        copies: &[usize],
        field: &SizeField<'_>,
        params: &GenerateParams,
    ) -> Result<Self, MeshError> {
        let limit = params.max_vertices;
        let planes = Planes(params.symmetry_planes);
        let mut meshes: Vec<SurfaceMesh> = Vec::new();
        let grid = offset_grid(bodies);
        let size = |x: Vec3| field.at(x);
        for (i, body) in bodies.iter().enumerate() {
            let first = copies[i];
            if first < i {
                let (from, to) = (bodies[first].surface.centre(), body.surface.centre());
                meshes.push(meshes[first].translated(from, to, grid));
                continue;
            }
            let mesh = triangulate(body.name, body.surface, &size, planes, limit)?;
            let centre = body.surface.centre();
            meshes.push(mesh.translated(centre, centre, grid));
        }
        let wall = container.surface();
        meshes.push(match container {
            Container::Ball(_) => triangulate(Container::TAG, wall, &size, planes, limit)?,
            Container::Box(b) => {
                triangulate_box(Container::TAG, wall, [b.min, b.max], &size, planes, limit)?
            }
            Container::Capsule(capsule) => {
                triangulate_capsule(capsule, field.edge_on_wall(), limit)?
            }
        });

        let mut layout = Layout {
            points: Vec::new(),
            free: Vec::new(),
            owner: Vec::new(),
            vertices: Vec::new(),
            triangles: Vec::new(),
            centres: 0..0,
            planes,
            surfaces: bodies.iter().map(|b| b.surface).collect(),
            container: wall,
            jumps: matches!(container, Container::Capsule(_)),
        };
        let mut seeds = Vec::new();
        for (k, mesh) in meshes.into_iter().enumerate() {
            let inwards = if k == bodies.len() { -1.0 } else { 1.0 };
            seeds.extend(apexes(&mesh, inwards, field));
            let mesh = planes.cut(mesh);
            let first = layout.points.len() as u32;
            layout.triangles.push(
                mesh.triangles
                    .iter()
                    .map(|t| t.map(|v| v + first))
                    .collect(),
            );
            layout.add(&mesh.points, k as u32, false);
            layout.vertices.push(first..layout.points.len() as u32);
        }
        let surfaces = &layout.surfaces;
        let packed = pack(field, surfaces, wall, planes, &layout.points, &seeds, limit)?;
        let first_centre = layout.points.len() as u32;
        for (k, body) in bodies.iter().enumerate() {
            layout.add(&[body.surface.centre()], k as u32, false);
        }
        layout.centres = first_centre..layout.points.len() as u32;
        // Along a curve through space: neighbours in the mesh are neighbours in memory.
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

    /// How far the midside nodes of boundary edges lie from the midpoints.
    pub fn bulges(&self, tets: &[[u32; 4]]) -> Bulges {
        let mut bulges = Bulges::new();
        for [a, b, c] in boundary_faces(tets) {
            let owner = self.owner[a as usize] as usize;
            let surface = self.surfaces.get(owner).unwrap_or(&self.container);
            let is_flat = self.plane_of([a, b, c]).is_some();
            for [i, j] in [[a, b], [b, c], [c, a]] {
                let [at, to] = [i, j].map(|v| self.points[v as usize]);
                // Each edge belongs to two faces, which turn about it in opposite senses; at a plane one of them is flat.
                if !is_flat && (i < j || !self.planes.through(&[at, to]).is_empty()) {
                    let middle = 0.5 * (at + to);
                    bulges.insert([i.min(j), i.max(j)], surface.closest_point(middle) - middle);
                }
            }
        }
        bulges
    }

    /// The axis that a face is normal to, if it is on a mirror plane.
    pub fn plane_of(&self, face: [u32; 3]) -> Option<usize> {
        let corners = face.map(|v| self.points[v as usize]);
        self.planes.through(&corners).axis()
    }

    /// Keeps the tets of the fluid: those that do not have all vertices on (or in) one body, which is convex, and are no flat ones on a wall
    /// whose curvature jumps.
    ///
    /// There, as at the ends of a cylinder, four of its vertices may lie nearly on a circle: the Delaunay tet
    /// between them has no height. Without it the wall runs along the other diagonal.
    pub fn fluid(&self, mut tets: Vec<[u32; 4]>) -> Vec<[u32; 4]> {
        let n_bodies = self.surfaces.len() as u32;
        tets.retain(|tet| {
            let owner = tet.map(|v| self.owner[v as usize]);
            if owner[0] < n_bodies {
                return owner.iter().any(|&o| o != owner[0]);
            }
            !self.jumps || owner.iter().any(|&o| o != n_bodies) || !self.is_flat(tet)
        });
        tets
    }

    /// Whether a tet's volume is far below that of a regular one with edges as long as its longest.
    fn is_flat(&self, tet: &[u32; 4]) -> bool {
        let [a, b, c, d] = tet.map(|v| self.points[v as usize]);
        let volume = (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0;
        let edges = [b - a, c - a, d - a, c - b, d - b, d - c];
        let longest = edges.iter().fold(0.0, |m: f64, e| m.max(e.norm()));
        volume < FLAT * longest.powi(3)
    }

    /// Moves free vertices to their targets, except where they would come too close to a surface; those on planes move in them.
    ///
    /// By symmetry the mean over the tets on both sides of a plane is that over one side less what is normal to it.
    pub fn move_free(&mut self, target: &[Vec3], field: &SizeField<'_>) {
        for (i, &to) in target.iter().enumerate() {
            if self.free[i] {
                let own = self.planes.at(self.points[i]);
                let to = own.along(to);
                let clear = 0.4 * field.at(to);
                let near = self.planes.distance(to, own) < clear
                    || -self.container.signed_distance(to) < clear
                    || self.surfaces.iter().any(|s| is_near(*s, to, clear));
                if !near {
                    self.points[i] = to;
                }
            }
        }
    }
}

/// Spacing of the grid on which surface points lie relative to their centre: the last bit of the largest coordinate of a body.
///
/// Then adding a centre that lies on the grid is exact, and copies differ by the same bits everywhere.
fn offset_grid(bodies: &[MeshedBody<'_>]) -> f64 {
    let reach = bodies.iter().map(|b| {
        let (centre, radius) = b.surface.bounding_ball();
        centre.amax() + radius
    });
    let largest = reach.fold(f64::MIN_POSITIVE, f64::max);
    2f64.powi(largest.log2().ceil() as i32) * f64::EPSILON
}

impl SurfaceMesh {
    /// The same triangulation about another centre, with offsets from it rounded to `grid`.
    fn translated(&self, from: Vec3, to: Vec3, grid: f64) -> Self {
        let points = self
            .points
            .iter()
            .map(|p| to + (p - from).map(|c| (c / grid).round() * grid))
            .collect();
        SurfaceMesh {
            points,
            triangles: self.triangles.clone(),
        }
    }
}

/// Apexes of nearly regular tets on the triangles, neighbour after neighbour, so that a packing takes every other one.
fn apexes(mesh: &SurfaceMesh, side: f64, field: &SizeField<'_>) -> Vec<Vec3> {
    let neighbours = mesh.neighbours();
    let mut seen = vec![false; mesh.triangles.len()];
    let mut queue = VecDeque::from([0usize]);
    let mut apexes = Vec::with_capacity(seen.len());
    seen[0] = true;
    while let Some(t) = queue.pop_front() {
        let [a, b, c] = mesh.triangles[t].map(|v| mesh.points[v as usize]);
        let normal = (b - a).cross(&(c - a)).normalize();
        let centroid = (a + b + c) / 3.0;
        apexes.push(centroid + (side * TET_HEIGHT * field.at(centroid)) * normal);
        for &n in &neighbours[t] {
            if !seen[n as usize] {
                seen[n as usize] = true;
                queue.push_back(n as usize);
            }
        }
    }
    apexes
}
