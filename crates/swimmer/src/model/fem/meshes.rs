//! The mesh of each shape: moved from a reference where that stays good, made anew where not.

use ale::{MovingBody, ReferenceMap, Stiffening};
use fem::TaylorHood;
use mesh::{Body, Container, GenerateParams, LinearTets, NamedSurface, Sphere, Surface, TetMesh};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::scale::Scale;
use crate::model::ModelError;
use crate::scene::{Domain, GeometryKind, Scene, Shape};

/// Remesh when the Jacobian of some cell falls below this part of its mean: quadratic fields on such cells are
/// poor and the solver slows down (61 iterations instead of 31 with one inverted cell).
const LEAST_JACOBIAN: f64 = 0.2;

/// Remesh when some mean ratio falls below this. Moves of four radii in one step stay at 0.3.
const LEAST_QUALITY: f64 = 0.1;

/// Element size on a body's surface, over its radius, when the scene asks for none.
pub const DEFAULT_SURFACE_SIZE: f64 = 0.25;

/// A body with a surface, in units of the flow.
#[derive(Clone, Copy, Debug)]
struct Surfaced {
    /// Index of the body in the scene.
    body: usize,
    radius: f64,
    size: f64,
}

/// Where meshes come from.
enum Source {
    /// Generated in a container.
    Generated(Container),
}

/// The mesh in use, and what is kept with its connectivity.
struct Current {
    map: ReferenceMap,
    space: TaylorHood,
    centres: Vec<Vector3<f64>>,
}

/// Meshes for the shapes of one scene, in units of the flow.
pub struct Meshes {
    source: Source,
    surfaced: Vec<Surfaced>,
    names: Vec<String>,
    geometry: GeometryKind,
    current: Option<Current>,
}

/// The mesh of one shape.
pub struct ShapeMesh {
    /// The mesh.
    pub mesh: TetMesh,
    /// Whether it was made anew rather than moved.
    pub remeshed: bool,
}

impl Meshes {
    /// Prepares meshes for a scene.
    ///
    /// # Errors
    /// A domain that cannot be meshed yet.
    pub fn new(scene: &Scene, scale: &Scale) -> Result<Self, ModelError> {
        let source = match &scene.domain {
            Domain::Ball { radius } => Source::Generated(Container::Ball(Sphere {
                centre: Vector3::zeros(),
                radius: scale.length(*radius),
            })),
            other => {
                return Err(ModelError::NotBuilt {
                    what: format!("finite elements in domain.kind = \"{}\"", other.kind().word()),
                    instead: "use domain.kind = \"ball\"".into(),
                });
            }
        };
        let surfaced = scene
            .bodies
            .iter()
            .enumerate()
            .filter_map(|(body, b)| match b.shape {
                Shape::Sphere { radius } => Some(Surfaced {
                    body,
                    radius: scale.length(radius),
                    size: scale.length(scene.fem.surface_size.unwrap_or(DEFAULT_SURFACE_SIZE * radius)),
                }),
                Shape::Point => None,
            })
            .collect();
        Ok(Self {
            source,
            surfaced,
            names: scene.bodies.iter().map(|b| b.name.clone()).collect(),
            geometry: scene.fem.geometry,
            current: None,
        })
    }

    /// Names of the bodies with surfaces: their tags in the mesh.
    pub fn tags(&self) -> impl Iterator<Item = &str> {
        self.surfaced.iter().map(|s| self.names[s.body].as_str())
    }

    /// Indices in the scene of the bodies with surfaces.
    pub fn surfaced_bodies(&self) -> impl Iterator<Item = usize> {
        self.surfaced.iter().map(|s| s.body)
    }

    /// Tag of the wall.
    pub fn wall_tags(&self) -> Vec<&str> {
        match &self.source {
            Source::Generated(_) => vec![Container::TAG],
        }
    }

    /// What is kept with the connectivity of the mesh in use.
    pub fn space(&self) -> Option<&TaylorHood> {
        self.current.as_ref().map(|current| &current.space)
    }

    /// The mesh with the bodies at `poses` (one a body of the scene): the reference moved, or a new reference
    /// where moving it would spoil it.
    ///
    /// # Errors
    /// Bodies that cannot be meshed around.
    pub fn at(&mut self, poses: &[Isometry3<f64>]) -> Result<ShapeMesh, ModelError> {
        if let Some(mesh) = self.moved(poses)? {
            return Ok(ShapeMesh { mesh, remeshed: false });
        }
        self.remesh(poses)?;
        match &self.current {
            Some(current) => Ok(ShapeMesh { mesh: current.map.reference().clone(), remeshed: true }),
            None => Err(ModelError::NoMesh),
        }
    }

    /// Makes the mesh with the bodies at `poses` the reference that later shapes are moved from.
    ///
    /// # Errors
    /// Bodies that cannot be meshed around.
    pub fn remesh(&mut self, poses: &[Isometry3<f64>]) -> Result<(), ModelError> {
        let centres: Vec<Vector3<f64>> =
            self.surfaced.iter().map(|s| poses[s.body].translation.vector).collect();
        let mesh = self.generate(&centres)?;
        let space = TaylorHood::new(&mesh)?;
        let moving: Vec<MovingBody> = self
            .tags()
            .zip(&centres)
            .map(|(tag, &centre)| MovingBody { tag: tag.to_owned(), centre, turns: false })
            .collect();
        let map = ReferenceMap::new(mesh, &moving, Stiffening::KanchiMasud)?;
        self.current = Some(Current { map, space, centres });
        Ok(())
    }

    /// The reference mesh moved to `poses`; none if there is no reference or the moved mesh would be poor.
    fn moved(&self, poses: &[Isometry3<f64>]) -> Result<Option<TetMesh>, ModelError> {
        let Some(current) = &self.current else { return Ok(None) };
        // Only spheres so far: turning one changes nothing, so its surface mesh is only translated.
        let motions: Vec<Isometry3<f64>> = self
            .surfaced
            .iter()
            .zip(&current.centres)
            .map(|(s, centre)| {
                let translation = poses[s.body].translation.vector - centre;
                Isometry3::from_parts(Translation3::from(translation), UnitQuaternion::identity())
            })
            .collect();
        let mesh = match current.map.moved(&motions) {
            Ok(mesh) => mesh,
            Err(ale::AleError::Invalid(_)) => return Ok(None),
            Err(other) => return Err(other.into()),
        };
        let quality = mesh.quality();
        Ok((quality.min_jacobian >= LEAST_JACOBIAN && quality.min_quality >= LEAST_QUALITY).then_some(mesh))
    }

    fn generate(&self, centres: &[Vector3<f64>]) -> Result<TetMesh, ModelError> {
        let Source::Generated(container) = &self.source;
        let spheres: Vec<Sphere> =
            self.surfaced.iter().zip(centres).map(|(s, &centre)| Sphere { centre, radius: s.radius }).collect();
        let bodies: Vec<Body> = self
            .surfaced
            .iter()
            .zip(self.tags())
            .zip(&spheres)
            .map(|((s, name), surface)| Body { name, surface, size: s.size })
            .collect();
        let tets = mesh::generate(&bodies, container, &GenerateParams::default())?.mesh;
        let surfaces: Vec<NamedSurface> = bodies
            .iter()
            .map(|b| (b.name, b.surface))
            .chain([(Container::TAG, container.surface())])
            .collect();
        self.quadratic(tets, &surfaces)
    }

    fn quadratic(&self, tets: LinearTets, surfaces: &[(&str, &dyn Surface)]) -> Result<TetMesh, ModelError> {
        Ok(match self.geometry {
            GeometryKind::Curved => TetMesh::curved(tets, surfaces)?,
            GeometryKind::Straight => TetMesh::straight(tets)?,
        })
    }
}
