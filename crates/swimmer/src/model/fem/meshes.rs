//! The mesh of each shape: moved from a reference where that stays good, made anew where not.

use ale::{MovingBody, ReferenceMap, Stiffening};
use fem::{SurplusSpace, TaylorHood};
use mesh::{Body, BoxSurface, Container, GenerateParams, NamedSurface, SizeMap, Sphere, TetMesh};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use super::far_field::FarField;
use super::mesh_file::read_mesh;
use super::scale::Scale;
use crate::model::ModelError;
use crate::scene::{Domain, FemOptions, GeometryKind, Scene, Shape};

/// Remesh when the Jacobian of some cell falls below this part of its mean: quadratic fields on such cells are
/// poor and the solver slows down (61 iterations instead of 31 with one inverted cell).
const LEAST_JACOBIAN: f64 = 0.2;

/// Remesh when some mean ratio falls below this. Moves of four radii in one step stay at 0.3.
const LEAST_QUALITY: f64 = 0.1;

/// Element size on a body's surface, over its radius, when the scene asks for none.
pub const DEFAULT_SURFACE_SIZE: f64 = 0.4;

/// The fastest growth of elements with the distance; faster costs quality.
const LARGEST_GROWTH: f64 = 0.3;

/// The fastest growth of adapted elements: where the flow is smooth they should be large soon, at some loss of quality (0.85 for 0.88).
const ADAPTED_GROWTH: f64 = 0.4;

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
struct Surfaced {
    /// Index of the body in the scene.
    body: usize,
    position: Vector3<f64>,
    radius: f64,
    size: f64,
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
enum Source {
    /// Generated in a container.
    Generated(Container),
    /// Read from a file, with the tags of its walls.
    File { mesh: TetMesh, walls: Vec<String> },
}

/// The mesh in use, and what is kept with its connectivity.
struct Current {
    map: ReferenceMap,
    space: TaylorHood,
    /// What error estimates need, once they were wanted.
    surplus: Option<SurplusSpace>,
    centres: Vec<Vector3<f64>>,
    /// Poses of all bodies of the scene in the reference; none for the mesh of a file.
    poses: Vec<Isometry3<f64>>,
}

/// Meshes for the shapes of one scene, in units of the flow.
pub struct Meshes {
    source: Source,
    surfaced: Vec<Surfaced>,
    /// Tag of each body of the scene in the mesh.
    tags: Vec<String>,
    geometry: GeometryKind,
    /// Sizes found by adapting; without them, sizes grow from the bodies.
    sizes: Option<SizeMap>,
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
        if let Some(number) = scene.first_spheroid() {
            return Err(ModelError::NotBuilt {
                what: format!(
                    "{}: shape = \"spheroid\" for finite elements in space",
                    scene.place(&format!("bodies[{number}].shape"))
                ),
                instead: "use model.kind = \"axisymmetric\" with all bodies on one axis, or shape = \"sphere\"".to_owned(),
            });
        }
        let surfaced: Vec<Surfaced> = scene
            .bodies
            .iter()
            .enumerate()
            .filter_map(|(body, b)| match b.shape {
                Shape::Sphere { radius } => Some(Surfaced {
                    body,
                    position: scale.point(b.position),
                    radius: scale.length(radius),
                    size: scale.length(surface_size(&scene.fem, radius)),
                }),
                // refused above
                Shape::Spheroid { .. } | Shape::Point => None,
            })
            .collect();
        let tags: Vec<String> = scene
            .bodies
            .iter()
            .map(|b| b.surface.clone().unwrap_or_else(|| b.name.clone()))
            .collect();
        let source = match &scene.domain {
            Domain::Unbounded => {
                Source::Generated(Container::Ball(FarField::of(scene, scale).map_or(
                    Sphere {
                        centre: Vector3::zeros(),
                        radius: 1.0,
                    },
                    |far| far.ball(),
                )))
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
            Domain::Mesh { file, walls } => {
                let spheres: Vec<(&str, Sphere)> = surfaced
                    .iter()
                    .map(|s| (tags[s.body].as_str(), s.sphere(s.position)))
                    .collect();
                let mesh = read_mesh(file, &spheres, walls, scene.fem.geometry, scale)?;
                Source::File {
                    mesh,
                    walls: walls.clone(),
                }
            }
            other => {
                return Err(ModelError::NotBuilt {
                    what: format!(
                        "finite elements in domain.kind = \"{}\"",
                        other.kind().word()
                    ),
                    instead: "use domain.kind = \"unbounded\", \"ball\", \"box\" or \"mesh\""
                        .into(),
                });
            }
        };
        Ok(Self {
            source,
            surfaced,
            tags,
            geometry: scene.fem.geometry,
            sizes: None,
            current: None,
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

    /// Radii of the bodies with surfaces.
    pub fn radii(&self) -> impl Iterator<Item = f64> {
        self.surfaced.iter().map(|s| s.radius)
    }

    /// Tag of the wall.
    pub fn wall_tags(&self) -> Vec<&str> {
        match &self.source {
            Source::Generated(_) => vec![Container::TAG],
            Source::File { walls, .. } => walls.iter().map(String::as_str).collect(),
        }
    }

    /// What is kept with the connectivity of the mesh in use.
    pub fn space(&self) -> Option<&TaylorHood> {
        self.current.as_ref().map(|current| &current.space)
    }

    /// What error estimates need of the mesh in use, if [`Meshes::prepare_estimates`] made it.
    pub fn surplus_space(&self) -> Option<&SurplusSpace> {
        self.current.as_ref()?.surplus.as_ref()
    }

    /// Numbers the cubic functions of the mesh in use.
    ///
    /// # Errors
    /// A mesh with too many cells.
    pub fn prepare_estimates(&mut self) -> Result<(), ModelError> {
        if let Some(current) = &mut self.current
            && current.surplus.is_none()
        {
            current.surplus = Some(SurplusSpace::new(current.map.reference())?);
        }
        Ok(())
    }

    /// The mesh with the bodies at `poses` (one a body of the scene): the reference moved, or a new reference
    /// where moving it would spoil it.
    ///
    /// # Errors
    /// Bodies that cannot be meshed around, or that have moved farther than a mesh from a file can follow.
    pub fn at(&mut self, poses: &[Isometry3<f64>]) -> Result<ShapeMesh, ModelError> {
        if let (None, Source::File { mesh, .. }) = (&self.current, &self.source) {
            let centres = self.surfaced.iter().map(|s| s.position).collect();
            self.current = Some(self.reference(mesh.clone(), centres, &[])?);
        }
        if let Some(mesh) = self.moved(poses)? {
            return Ok(ShapeMesh {
                mesh,
                remeshed: false,
            });
        }
        if let Source::File { .. } = &self.source {
            return Err(ModelError::MeshFileExhausted);
        }
        self.remesh(poses)?;
        let current = self.current.as_ref().ok_or(ModelError::NoMesh)?;
        Ok(ShapeMesh {
            mesh: current.map.reference().clone(),
            remeshed: true,
        })
    }

    /// Makes the mesh with the bodies at `poses` the reference that later shapes are moved from.
    ///
    /// # Errors
    /// Bodies that cannot be meshed around.
    pub fn remesh(&mut self, poses: &[Isometry3<f64>]) -> Result<(), ModelError> {
        let centres: Vec<Vector3<f64>> = self
            .surfaced
            .iter()
            .map(|s| poses[s.body].translation.vector)
            .collect();
        let mesh = self.generate(&centres)?;
        self.current = Some(self.reference(mesh, centres, poses)?);
        Ok(())
    }

    /// Makes a new reference at `poses` with edges as long as `wanted` at places in the mesh in use; none if meshes cannot be made here.
    ///
    /// Bodies that are equal get equal meshes, so what one of them needs nearby, all of them get.
    ///
    /// # Errors
    /// Sizes that are not positive, bodies that cannot be meshed around.
    pub fn adapt(
        &mut self,
        poses: &[Isometry3<f64>],
        mut wanted: Vec<(Vector3<f64>, f64)>,
    ) -> Result<Option<ShapeMesh>, ModelError> {
        if let Source::File { .. } = &self.source {
            return Ok(None);
        }
        let centres: Vec<Vector3<f64>> = self
            .surfaced
            .iter()
            .map(|s| poses[s.body].translation.vector)
            .collect();
        for k in 0..wanted.len() {
            let (at, size) = wanted[k];
            for (s, centre) in self.surfaced.iter().zip(&centres) {
                if (at - centre).norm() > 2.0 * s.radius {
                    continue;
                }
                for (other, there) in self.surfaced.iter().zip(&centres) {
                    if other.body != s.body && (other.radius, other.size) == (s.radius, s.size) {
                        wanted.push((at - centre + there, size));
                    }
                }
            }
        }
        self.sizes = Some(SizeMap::new(wanted, ADAPTED_GROWTH)?);
        self.remesh(poses)?;
        let current = self.current.as_ref().ok_or(ModelError::NoMesh)?;
        Ok(Some(ShapeMesh {
            mesh: current.map.reference().clone(),
            remeshed: true,
        }))
    }

    /// The poses that the reference was made for, from which [`Meshes::restore`] makes the same one.
    pub fn reference_poses(&self) -> Vec<Isometry3<f64>> {
        self.current
            .as_ref()
            .map_or_else(Vec::new, |current| current.poses.clone())
    }

    /// Makes the reference of an earlier run again, bit for bit.
    ///
    /// # Errors
    /// Poses of another number of bodies, or such as cannot be meshed.
    pub fn restore(&mut self, poses: &[Isometry3<f64>]) -> Result<(), ModelError> {
        match poses.len() {
            0 => Ok(()),
            bodies if bodies == self.tags.len() => self.remesh(poses),
            found => Err(rigid::RigidError::Length {
                what: "poses of the reference mesh",
                expected: self.tags.len(),
                found,
            }
            .into()),
        }
    }

    fn reference(
        &self,
        mesh: TetMesh,
        centres: Vec<Vector3<f64>>,
        poses: &[Isometry3<f64>],
    ) -> Result<Current, ModelError> {
        let space = TaylorHood::new(&mesh)?;
        let moving: Vec<MovingBody> = self
            .tags()
            .zip(&centres)
            .map(|(tag, &centre)| MovingBody {
                tag: tag.to_owned(),
                centre,
                turns: false,
            })
            .collect();
        let map = ReferenceMap::new(mesh, &moving, Stiffening::KanchiMasud)?;
        Ok(Current {
            map,
            space,
            surplus: None,
            centres,
            poses: poses.to_vec(),
        })
    }

    /// The reference mesh moved to `poses`; none if there is no reference or the moved mesh would be poor.
    fn moved(&self, poses: &[Isometry3<f64>]) -> Result<Option<TetMesh>, ModelError> {
        let Some(current) = &self.current else {
            return Ok(None);
        };
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
        Ok(
            (quality.min_jacobian >= LEAST_JACOBIAN && quality.min_quality >= LEAST_QUALITY)
                .then_some(mesh),
        )
    }

    fn generate(&self, centres: &[Vector3<f64>]) -> Result<TetMesh, ModelError> {
        let Source::Generated(container) = &self.source else {
            return Err(ModelError::MeshFileExhausted);
        };
        let spheres: Vec<Sphere> = self
            .surfaced
            .iter()
            .zip(centres)
            .map(|(s, &centre)| s.sphere(centre))
            .collect();
        let bodies: Vec<Body> = self
            .surfaced
            .iter()
            .zip(self.tags())
            .zip(&spheres)
            .map(|((s, name), surface)| Body {
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
