//! Meshes around the bodies of a scene, wherever they are: in a container or from a file.

use mesh::{
    BoxSurface, Capsule, Container, GenerateParams, MeshedBody, NamedSurface, SizeMap, Sphere,
    Surface, TetMesh,
};
use nalgebra::{Isometry3, Vector3};

use super::far_field::FarField;
use super::mesh_file::read_mesh;
use super::tube;
use crate::ModelError;
use crate::scale::Scale;
use scene::{Domain, FemOptions, GeometryKind, Scene, Shape};

/// Element size on a body's surface, over its radius, when the scene asks for none.
pub const DEFAULT_SURFACE_SIZE: f64 = 0.4;

/// The fastest growth of elements with the distance; faster costs quality.
const LARGEST_GROWTH: f64 = 0.3;

/// The fastest growth of adapted elements: where the flow is smooth they should be large soon, at some loss of quality (0.85 for 0.88).
const ADAPTED_GROWTH: f64 = 0.4;

/// Gaps below this part of the smaller radius ask for more of the preconditioner: with gaps of one radius iterations are those of wide ones, with a
/// third of it there are a sixth more.
const NARROW: f64 = 0.5;

/// Factor on element sizes that refinement starts from: 0.7 radii, the coarsest that follows a sphere.
pub const COARSEST_FACTOR: f64 = 1.75;

/// Element size on the surface of a body.
fn surface_size(options: &FemOptions, radius: f64) -> f64 {
    let factor = options.size_factor.unwrap_or(match options.target {
        None => 1.0,
        Some(_) => COARSEST_FACTOR,
    });
    factor
        * options
            .surface_size
            .unwrap_or(DEFAULT_SURFACE_SIZE * radius)
}

/// Growth of the element size with the distance from a body, for elements of `size` radii on it.
///
/// Around a sphere the third derivatives of the flow fall like $r^{-4}$, so the error of quadratic elements of size `h` is
/// $\int h^4 r^{-8} r^2 dr$; for a given number of elements $\int h^{-3} r^2 dr$ it is least when $h = h_s r^{8/7}$: the size grows by
/// 8/7 of the surface size a radius. A fixed growth would leave an error that no surface size removes.
pub fn growth(size: f64) -> f64 {
    (8.0 / 7.0 * size).min(LARGEST_GROWTH)
}

/// A body with a surface, in units of the flow.
#[derive(Clone, Copy, Debug)]
pub(super) struct Surfaced {
    /// Index of the body in the scene.
    pub body: usize,
    pub position: Vector3<f64>,
    pub radius: f64,
    pub size: f64,
}

impl Surfaced {
    fn sphere(&self, centre: Vector3<f64>) -> Sphere {
        Sphere {
            centre,
            radius: self.radius,
        }
    }
}

/// Where meshes come from.
pub(super) enum Source {
    /// Generated in a container.
    Generated(Container),
    /// Generated in a piece of the cylinder of this radius about the x axis.
    Cylinder(f64),
    /// Read from a file, with the tags of its walls.
    File { mesh: TetMesh, walls: Vec<String> },
}

/// What meshes of a scene are made of, in units of the flow.
pub(super) struct Mesher {
    pub source: Source,
    /// Of unbounded fluid.
    pub far_field: Option<FarField>,
    pub surfaced: Vec<Surfaced>,
    /// Tag of each body of the scene in the mesh.
    pub tags: Vec<String>,
    geometry: GeometryKind,
    /// Planes of which one side is meshed, by the axes they are normal to.
    pub mirrors: [bool; 3],
    /// Sizes found by adapting; without them, sizes grow from the bodies.
    sizes: Option<SizeMap>,
}

impl Mesher {
    /// What meshes of a scene are made of.
    ///
    /// # Errors
    /// A domain that cannot be meshed yet.
    pub fn new(scene: &Scene, scale: &Scale) -> Result<Self, ModelError> {
        if let Some(number) = scene.first_spheroid() {
            return Err(ModelError::Unsupported {
                what: format!(
                    "{}: shape = \"spheroid\" for finite elements in space",
                    scene.place(&format!("bodies[{number}].shape"))
                ),
                instead: "use model.kind = \"axisymmetric\" with all bodies on one axis, or shape = \"sphere\"".to_owned(),
            });
        }
        let surfaced: Vec<Surfaced> = scene
            .bodies()
            .iter()
            .enumerate()
            .filter_map(|(body, b)| match b.shape {
                Shape::Sphere { radius } => Some(Surfaced {
                    body,
                    position: scale.point(b.position),
                    radius: scale.length(radius),
                    size: scale.length(surface_size(scene.fem(), radius)),
                }),
                // refused above
                Shape::Spheroid { .. } | Shape::Point => None,
            })
            .collect();
        let tags: Vec<String> = scene
            .bodies()
            .iter()
            .map(|b| b.surface.clone().unwrap_or_else(|| b.name.clone()))
            .collect();
        let mut far_field = None;
        let source = match scene.domain() {
            Domain::Unbounded => {
                let far = far_field.insert(FarField::around(scene, scale));
                Source::Generated(Container::Ball(far.ball()))
            }
            Domain::Ball { radius } => Source::Generated(Container::Ball(Sphere {
                centre: Vector3::zeros(),
                radius: scale.length(*radius),
            })),
            Domain::Box { size } => {
                let half = scale.point(size / 2.0);
                Source::Generated(Container::Box(BoxSurface {
                    min: -half,
                    max: half,
                }))
            }
            Domain::Cylinder { radius } => Source::Cylinder(scale.length(*radius)),
            Domain::Mesh { file, walls } => {
                let spheres: Vec<(&str, Sphere)> = surfaced
                    .iter()
                    .map(|s| (tags[s.body].as_str(), s.sphere(s.position)))
                    .collect();
                let mesh = read_mesh(file, &spheres, walls, scene.fem().geometry, scale)?;
                Source::File {
                    mesh,
                    walls: walls.clone(),
                }
            }
            other => {
                return Err(ModelError::Unsupported {
                    what: format!(
                        "finite elements in domain.kind = \"{}\"",
                        other.kind().word()
                    ),
                    instead: "use domain.kind = \"unbounded\", \"ball\", \"box\", \"cylinder\" or \"mesh\""
                        .into(),
                });
            }
        };
        Ok(Self {
            source,
            far_field,
            surfaced,
            tags,
            geometry: scene.fem().geometry,
            mirrors: scene.fem_symmetry_planes(),
            sizes: None,
        })
    }

    /// Names of the bodies with surfaces: their tags in the mesh.
    pub fn tags(&self) -> impl Iterator<Item = &str> {
        self.surfaced.iter().map(|s| self.tags[s.body].as_str())
    }

    /// Indices in the scene of the bodies with surfaces.
    pub fn surfaced_bodies(&self) -> impl Iterator<Item = usize> {
        self.surfaced.iter().map(|s| s.body)
    }

    /// Tag of the wall.
    pub fn wall_tags(&self) -> Vec<&str> {
        match &self.source {
            Source::Generated(_) | Source::Cylinder(_) => vec![Container::TAG],
            Source::File { walls, .. } => walls.iter().map(String::as_str).collect(),
        }
    }

    /// Centres of the bodies with surfaces.
    pub fn centres(&self, poses: &[Isometry3<f64>]) -> Vec<Vector3<f64>> {
        self.surfaced
            .iter()
            .map(|s| poses[s.body].translation.vector)
            .collect()
    }

    /// The spheres that straight facets stand for, with the tags of these facets, the bodies being at `centres`; none where facets are curved.
    pub fn straight_spheres(&self, centres: &[Vector3<f64>]) -> Vec<(&str, Sphere)> {
        if self.geometry == GeometryKind::Curved {
            return Vec::new();
        }
        let wall = match &self.source {
            Source::Generated(Container::Ball(ball)) => Some((Container::TAG, *ball)),
            // Boxes are flat, pieces of cylinders follow the bodies, and nobody knows what walls in a file stand for.
            Source::Generated(_) | Source::Cylinder(_) | Source::File { .. } => None,
        };
        self.tags().zip(self.spheres(centres)).chain(wall).collect()
    }

    /// What holds the fluid around the bodies; none for the mesh of a file.
    fn container(&self, bodies: &[Sphere]) -> Option<Container> {
        match &self.source {
            Source::Generated(container) => Some(*container),
            Source::Cylinder(radius) => Some(Container::Capsule(tube::around(*radius, bodies))),
            Source::File { .. } => None,
        }
    }

    /// The piece of a cylinder in which a mesh with the bodies at `centres` is made.
    pub fn tube(&self, centres: &[Vector3<f64>]) -> Option<Capsule> {
        match self.container(&self.spheres(centres)) {
            Some(Container::Capsule(capsule)) => Some(capsule),
            _ => None,
        }
    }

    /// Spheres with the bodies' radii at `centres`.
    pub fn spheres(&self, centres: &[Vector3<f64>]) -> Vec<Sphere> {
        (self.surfaced.iter().zip(centres))
            .map(|(s, &centre)| s.sphere(centre))
            .collect()
    }

    /// Takes sizes `wanted` at places in a mesh with the bodies at `centres` instead of those that grow from the bodies.
    ///
    /// Bodies that are equal get equal meshes, so what one of them needs nearby, all of them get.
    ///
    /// # Errors
    /// Sizes that are not positive.
    pub fn adapt(
        &mut self,
        centres: &[Vector3<f64>],
        mut wanted: Vec<(Vector3<f64>, f64)>,
    ) -> Result<(), ModelError> {
        for k in 0..wanted.len() {
            let (at, size) = wanted[k];
            for (s, centre) in self.surfaced.iter().zip(centres) {
                if (at - centre).norm() > 2.0 * s.radius {
                    continue;
                }
                for (other, there) in self.surfaced.iter().zip(centres) {
                    if other.body != s.body && (other.radius, other.size) == (s.radius, s.size) {
                        wanted.push((at - centre + there, size));
                    }
                }
            }
        }
        self.sizes = Some(SizeMap::new(wanted, ADAPTED_GROWTH)?);
        Ok(())
    }

    /// How long cells in gaps are against the gaps.
    pub fn gap_ratio(&self, mesh: &TetMesh, centres: &[Vector3<f64>]) -> f64 {
        let spheres = self.spheres(centres);
        let surfaces: Vec<&dyn Surface> = spheres.iter().map(|s| s as &dyn Surface).collect();
        let container = self.container(&spheres);
        mesh.gap_ratio(&surfaces, container.as_ref().map(Container::surface))
    }

    /// For each cell `h^2 / 6` with the width `h` of the gap that it lies in, twice what lubrication makes of a gap; none if no gap between the
    /// bodies at `centres` and the wall is narrow.
    pub fn permeability(&self, mesh: &TetMesh, centres: &[Vector3<f64>]) -> Option<Vec<f64>> {
        let spheres = self.spheres(centres);
        let container = self.container(&spheres);
        let wall = container.as_ref().map(Container::surface);
        let narrow = |gap: f64, radius: f64| gap < NARROW * radius;
        let is_near_others = |(k, a): (usize, &Sphere)| {
            spheres[..k].iter().any(|b| {
                let gap = b.signed_distance(a.centre) - a.radius;
                narrow(gap, a.radius.min(b.radius))
            })
        };
        let is_near_wall = |a: &Sphere| {
            wall.is_some_and(|wall| narrow(-wall.signed_distance(a.centre) - a.radius, a.radius))
        };
        let is_narrow =
            spheres.iter().enumerate().any(is_near_others) || spheres.iter().any(is_near_wall);
        is_narrow.then(|| {
            let surfaces: Vec<&dyn Surface> = spheres.iter().map(|s| s as &dyn Surface).collect();
            let widths = mesh.gap_widths(&surfaces, wall);
            widths.into_iter().map(|h| h * h / 6.0).collect()
        })
    }

    /// The mesh with the bodies at `centres`.
    ///
    /// # Errors
    /// Bodies that cannot be meshed around, or a mesh from a file, which cannot be made again.
    pub fn generate(&self, centres: &[Vector3<f64>]) -> Result<TetMesh, ModelError> {
        let spheres = self.spheres(centres);
        let Some(container) = &self.container(&spheres) else {
            return Err(ModelError::MeshFileExhausted);
        };
        let bodies: Vec<MeshedBody> = self
            .surfaced
            .iter()
            .zip(self.tags())
            .zip(&spheres)
            .map(|((s, name), surface)| MeshedBody {
                name,
                surface,
                size: s.size,
            })
            .collect();
        let finest = self
            .surfaced
            .iter()
            .map(|s| s.size / s.radius)
            .fold(f64::INFINITY, f64::min);
        let mut parameters = GenerateParams::default();
        parameters.growth = growth(finest);
        parameters.symmetry_planes = self.mirrors;
        let tets = match &self.sizes {
            None => mesh::generate(&bodies, container, &parameters)?.mesh,
            Some(sizes) => {
                parameters.growth = ADAPTED_GROWTH;
                mesh::generate_sized(&bodies, container, &parameters, &|x| sizes.at(x))?.mesh
            }
        };
        let surfaces: Vec<NamedSurface> = bodies
            .iter()
            .map(|b| (b.name, b.surface))
            .chain([(Container::TAG, container.surface())])
            .collect();
        Ok(match self.geometry {
            GeometryKind::Curved => TetMesh::curved(tets, &surfaces)?,
            GeometryKind::Straight => TetMesh::straight(tets)?,
        })
    }
}
