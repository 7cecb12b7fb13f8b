//! The triangulations of all surfaces of a scene.

use super::capsule_mesh::triangulate_capsule;
use super::input::Container;
use super::input::GenerateParams;
use super::input::MeshedBody;
use super::layout::{Layout, Part, WallKind};
use super::recovered_surfaces::Missing;
use super::size_field::SizeField;
use super::surface_refinement::Refiner;
use super::surface_triangulation::{triangulate, triangulate_box};
use super::symmetry_planes::SymmetryPlanes;
use crate::GenerateError;
use crate::surface::triangles::translated;
use mesh::{Surface, SurfaceMesh, Vec3};

/// Ratio of the edges of a surface with sharp edges to the wanted length below which the latter is
/// lowered.
///
/// Edges are 1.05 times the wanted length on average. With 0.7, 24 to 32 sides of 0.26 to 0.4
/// wanted lengths left a mean quality of 0.53 to 0.75.
const SHORT: f64 = 0.9;

/// The triangulations of bodies and container.
pub(crate) struct Triangulations<'a, 'f> {
    bodies: &'f [MeshedBody<'a>],
    container: &'a Container,
    /// For each body the first one of which it is a copy.
    copies: &'f [usize],
    field: SizeField<'f>,
    planes: SymmetryPlanes,
    limit: usize,
    /// Those of the bodies, then that of the container.
    meshes: Vec<SurfaceMesh>,
}

impl<'a, 'f> Triangulations<'a, 'f> {
    /// Triangulates all surfaces.
    ///
    /// # Errors
    /// [`GenerateError::TooManyVertices`], [`GenerateError::SurfaceNotRecovered`].
    pub fn new(
        bodies: &'f [MeshedBody<'a>],
        container: &'a Container,
        copies: &'f [usize],
        field: SizeField<'f>,
        params: &GenerateParams,
    ) -> Result<Self, GenerateError> {
        let limit = params.max_vertices;
        let planes = SymmetryPlanes(params.symmetry_planes);
        let size = |x: Vec3| field.at(x);
        let mut meshes = triangulate_bodies(bodies, copies, &field, planes, limit)?;
        let wall = container.surface();
        meshes.push(match container {
            Container::Ball(_) | Container::Surface(_) => {
                triangulate(Container::TAG, wall, &size, planes, limit)?
            }
            Container::Box(b) => {
                triangulate_box(Container::TAG, wall, [b.min, b.max], &size, planes, limit)?
            }
            Container::Capsule(capsule) => {
                triangulate_capsule(capsule, field.edge_on_wall(), limit)?
            }
        });
        let mut surfaces = Self {
            bodies,
            container,
            copies,
            field,
            planes,
            limit,
            meshes,
        };
        surfaces.limit_sizes()?;
        Ok(surfaces)
    }

    /// The wanted edge lengths, limited near short edges of the triangulations.
    pub fn field(&self) -> &SizeField<'f> {
        &self.field
    }

    /// Whether the triangles of a part are given: those of surfaces with sharp edges.
    ///
    /// Beside such edges the tets alone do not tell which of them are inside.
    fn is_given(&self, part: usize) -> bool {
        let surface = self.surface(part).1;
        surface.closest_on_sharp_edges(surface.centre()).is_some()
    }

    /// Name and surface of a body or the container.
    fn surface(&self, part: usize) -> (&'a str, &'a dyn Surface) {
        match self.bodies.get(part) {
            Some(body) => (body.name, body.surface),
            None => (Container::TAG, self.container.surface()),
        }
    }

    /// Limits the wanted edge lengths near vertices whose edges are shorter: sharp edges may be
    /// closer together than wanted.
    fn limit_sizes(&mut self) -> Result<(), GenerateError> {
        self.field.limit_near(Vec::new())?;
        let mut short = Vec::new();
        for part in (0..self.meshes.len()).filter(|&part| self.is_given(part)) {
            let mesh = &self.meshes[part];
            let mut sums = vec![(0.0, 0.0); mesh.points.len()];
            for &[a, b, c] in &mesh.triangles {
                for [a, b] in [[a, b], [b, c], [c, a]].map(|edge| edge.map(|v| v as usize)) {
                    let (sum, count) = &mut sums[a];
                    *sum += (mesh.points[a] - mesh.points[b]).norm();
                    *count += 1.0;
                }
            }
            let lengths = mesh.points.iter().zip(sums);
            let lengths = lengths.map(|(x, (sum, count))| (*x, sum / count));
            short.extend(lengths.filter(|(x, length)| *length < SHORT * self.field.at(*x)));
        }
        self.field.limit_near(short)
    }

    /// Places all vertices: surfaces first, then centres of bodies, then the fluid.
    ///
    /// # Errors
    /// [`GenerateError::TooManyVertices`].
    pub fn layout(&self) -> Result<Layout<'a>, GenerateError> {
        let parts = (self.meshes.iter().enumerate())
            .map(|(part, mesh)| Part {
                surface: self.surface(part).1,
                mesh: mesh.clone(),
                is_given: self.is_given(part),
            })
            .collect();
        let mut layout = Layout::new(parts, self.planes, &self.field, self.limit)?;
        layout.wall = match self.container {
            Container::Ball(_) | Container::Box(_) => WallKind::Hull,
            Container::Capsule(_) => WallKind::CurvatureJumps,
            Container::Surface(_) => WallKind::AnyShape,
        };
        Ok(layout)
    }

    /// The error for a triangle that is missing.
    pub fn not_recovered(&self, part: usize, triangle: usize) -> GenerateError {
        let mesh = &self.meshes[part];
        GenerateError::SurfaceNotRecovered {
            body: self.surface(part).0.into(),
            at: mesh.points[mesh.triangles[triangle][0] as usize].into(),
        }
    }

    /// Changes triangles that are missing among the faces of the tets; copies change alike.
    ///
    /// # Errors
    /// Those of [`SizeMap::new`](super::SizeMap::new).
    pub fn change(&mut self, missing: &[Missing]) -> Result<(), GenerateError> {
        let size = |x: Vec3| self.field.at(x);
        let grid = offset_grid(self.bodies);
        let first = |part: usize| self.copies.get(part).copied().unwrap_or(part);
        for part in (0..self.meshes.len()).filter(|&part| first(part) == part) {
            let missing: Vec<&Missing> = (missing.iter())
                .filter(|missing| first(missing.part) == part)
                .collect();
            if missing.is_empty() {
                continue;
            }
            let (name, surface) = self.surface(part);
            let mesh = std::mem::take(&mut self.meshes[part]);
            let planes = self.planes.at(surface.centre());
            let changed = Refiner::new(mesh, name, surface, &size, planes).changed(&missing);
            self.meshes[part] = changed;
            for copy in (part + 1..self.bodies.len()).filter(|&copy| first(copy) == part) {
                let (from, to) = (surface.centre(), self.bodies[copy].surface.centre());
                self.meshes[copy] = translated(&self.meshes[part], from, to, grid);
            }
        }
        self.limit_sizes()
    }
}

/// Triangulates the surfaces of bodies; copies get the translated triangles of the first one.
///
/// # Errors
/// Those of [`triangulate`].
pub(crate) fn triangulate_bodies(
    bodies: &[MeshedBody<'_>],
    copies: &[usize],
    field: &SizeField<'_>,
    planes: SymmetryPlanes,
    limit: usize,
) -> Result<Vec<SurfaceMesh>, GenerateError> {
    let mut meshes: Vec<SurfaceMesh> = Vec::new();
    let grid = offset_grid(bodies);
    let size = |x: Vec3| field.at(x);
    for (i, body) in bodies.iter().enumerate() {
        let (first, centre) = (copies[i], body.surface.centre());
        meshes.push(if first < i {
            translated(&meshes[first], bodies[first].surface.centre(), centre, grid)
        } else {
            // Planes beside the body do not restrict its triangles.
            let cutting = planes.at(centre);
            let mesh = triangulate(body.name, body.surface, &size, cutting, limit)?;
            translated(&mesh, centre, centre, grid)
        });
    }
    Ok(meshes)
}

/// Spacing of the grid on which surface points lie relative to their centre.
///
/// The spacing is the last bit of the largest coordinate of any body.
///
/// Adding a centre that lies on the grid is then exact, and copies are bitwise equal up to
/// translation.
fn offset_grid(bodies: &[MeshedBody<'_>]) -> f64 {
    let extents = bodies.iter().map(|b| {
        let (centre, radius) = b.surface.bounding_ball();
        centre.amax() + radius
    });
    let largest = extents.fold(f64::MIN_POSITIVE, f64::max);
    2f64.powi(largest.log2().ceil() as i32) * f64::EPSILON
}
