//! Generation of meshes around the bodies of a scene, in scaled units.

use mesh::{NamedSurface, SYMMETRY_PLANE_TAGS, Surface, TetMesh};
use mesher::{
    BoxSurface, Capsule, Container, GenerateParams, MeshedBody, MovedBody, SizeMap, Sphere,
};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use super::cylinder;
use super::element_size::{ADAPTED_GROWTH, MAX_COARSE_GROWTH, growth, surface_size};
use super::far_field::FarField;
use super::mesh_file;
use crate::ModelError;
use crate::units::Scale;
use scene::{Deformation, Domain, GeometryKind, MesherKind, Scene, Shape};

/// Width of a gap, relative to the smaller radius, below which it counts as narrow.
///
/// At one radius the preconditioner needs as many iterations as for wide gaps; at a third of a
/// radius it needs a sixth more.
const NARROW_GAP: f64 = 0.5;

/// Distance from a symmetry plane, in radii, that counts as rounding error of many steps.
///
/// Bodies that are farther away from the plane are refused.
const PLANE_ROUNDING: f64 = 1e-9;

/// Name of the boundary part on the plane wall.
const PLANE_WALL: &str = "wall";

/// A body with a surface, in scaled units.
#[derive(Clone, Debug)]
pub(super) struct Surfaced {
    /// Index of the body in the scene.
    pub body: usize,
    /// Pose in the initial configuration of the scene.
    pub pose: Isometry3<f64>,
    /// Radius of the ball about the centre that contains the body.
    pub radius: f64,
    /// Element size on the surface.
    pub size: f64,
    /// The same relative to the radius on which sizes are based.
    pub relative_size: f64,
    /// Shape in the units of the scene; the undeformed one of a body that deforms.
    pub shape: Shape,
    /// Deformation in the units of the scene.
    pub deformation: Option<Deformation>,
}

impl Surfaced {
    /// The motion of the body from its initial pose to another one.
    ///
    /// Rotations do not change spheres, whose surface meshes are translated.
    fn motion(&self, pose: &Isometry3<f64>) -> Isometry3<f64> {
        let from = &self.pose;
        match self.is_isotropic() {
            true => Translation3::from(pose.translation.vector - from.translation.vector).into(),
            false => pose * from.inverse(),
        }
    }

    /// Whether rotations do not change the surface, whatever the deformation.
    pub fn is_isotropic(&self) -> bool {
        let stays_sphere = |deformation: &Deformation| deformation.is_sphere();
        self.shape.is_isotropic() && self.deformation.as_ref().is_none_or(stays_sphere)
    }

    /// Size of the body at these values of the joints, relative to that of the scene.
    fn growth(&self, values: &[f64]) -> f64 {
        let sphere = self.deformation.as_ref().and_then(Deformation::sphere);
        sphere.map_or(1.0, |of| of.sphere_radius(values) / of.radius)
    }

    /// Element size on the surface at these values of the joints.
    fn size_at(&self, values: &[f64]) -> f64 {
        self.size * self.growth(values)
    }
}

/// Poses of bodies, either of all or of those with surfaces, and what their shapes depend on.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Placement {
    /// Scaled poses.
    pub poses: Vec<Isometry3<f64>>,
    /// Values of all joints in the units of the scene; empty if no body deforms.
    pub values: Vec<f64>,
}

impl Placement {
    /// Poses of bodies that do not deform.
    pub fn rigid(poses: &[Isometry3<f64>]) -> Self {
        Self {
            poses: poses.to_vec(),
            values: Vec::new(),
        }
    }
}

/// Where meshes come from.
pub(super) enum Source {
    /// Generated in a container.
    Generated(Container),
    /// Generated in a part of the cylinder of this radius about the x axis.
    Cylinder(f64),
    /// Read from a file, with the names of its walls.
    File { mesh: TetMesh, walls: Vec<String> },
}

impl Source {
    /// Where the meshes of a scene come from; reads the mesh file if there is one.
    ///
    /// # Errors
    /// A file that cannot be read; a periodic box.
    fn new(
        scene: &Scene,
        scale: &Scale,
        surfaced: &[Surfaced],
        tags: &[String],
    ) -> Result<Self, ModelError> {
        Ok(match scene.domain() {
            Domain::Unbounded | Domain::Wall => {
                Self::Generated(Container::Ball(FarField::new(scene, scale).ball()))
            }
            Domain::Ball { radius } => Self::Generated(Container::Ball(Sphere {
                centre: Vector3::zeros(),
                radius: scale.length(*radius),
            })),
            Domain::Box { size } => {
                let half = scale.length(size / 2.0);
                Self::Generated(Container::Box(BoxSurface {
                    min: -half,
                    max: half,
                }))
            }
            Domain::Periodic { .. } => {
                let what = format!("{}: a periodic box by elements", scene.place("domain.kind"));
                let instead =
                    "use spheres with model.kind = \"rpy\" or \"oseen\", or the domain box";
                return Err(ModelError::unsupported(what, instead));
            }
            Domain::Cylinder { radius } => Self::Cylinder(scale.length(*radius)),
            Domain::Surface(domain) => {
                Self::Generated(Container::Surface(domain.surface.scaled(scale.length(1.0))))
            }
            Domain::Mesh { file, walls, .. } => {
                let surfaces: Vec<(&str, Box<dyn Surface>)> = (surfaced.iter())
                    .filter(|s| !s.shape.is_mesh_part())
                    .filter_map(|s| {
                        let surface = scale.surface(&s.shape, &s.pose)?;
                        Some((tags[s.body].as_str(), surface))
                    })
                    .collect();
                let surfaces: Vec<NamedSurface> =
                    surfaces.iter().map(|(name, s)| (*name, &**s)).collect();
                let of_bodies = surfaced.iter().map(|s| &tags[s.body]);
                let known: Vec<&String> = of_bodies.chain(walls).collect();
                let geometry = scene.fem().geometry;
                let mesh = mesh_file::read_mesh(file, &surfaces, &known, geometry, scale)?;
                Self::File {
                    mesh,
                    walls: walls.clone(),
                }
            }
        })
    }
}

/// Generator of meshes for one scene.
pub(super) struct MeshGenerator {
    scale: Scale,
    pub source: Source,
    /// The ball or half ball that replaces unbounded fluid.
    pub far_field: Option<FarField>,
    pub surfaced: Vec<Surfaced>,
    /// Name of the boundary part of each body of the scene.
    pub tags: Vec<String>,
    /// Number of joints, of a scene with bodies that deform; zero otherwise.
    pub deforming_joints: usize,
    geometry: GeometryKind,
    mesher: MesherKind,
    /// For each axis, whether the plane normal to it is a symmetry plane; one side is meshed.
    pub symmetry_planes: [bool; 3],
    /// Element sizes of an adapted mesh; without them, sizes grow with the distance from bodies.
    sizes: Option<SizeMap>,
    /// Factor on all element sizes, those far from bodies included.
    coarsening: f64,
}

impl MeshGenerator {
    /// Creates the generator for a scene; reads the mesh file if there is one.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn new(scene: &Scene, scale: &Scale) -> Result<Self, ModelError> {
        let surfaced: Vec<Surfaced> = (scene.bodies().iter().enumerate())
            .filter(|(_, b)| b.shape.has_surface())
            .map(|(body, b)| {
                let size = surface_size(scene.fem(), b.shape.size_radius());
                Surfaced {
                    body,
                    pose: Translation3::from(scale.length(b.position)).into(),
                    radius: scale.length(b.bounding_radius()),
                    size: scale.length(size),
                    relative_size: size / b.shape.size_radius(),
                    shape: b.shape.clone(),
                    deformation: b.deformation.clone(),
                }
            })
            .collect();
        let tags: Vec<String> = scene
            .bodies()
            .iter()
            .map(|b| b.surface.clone().unwrap_or_else(|| b.name.clone()))
            .collect();
        let is_truncated = matches!(scene.domain(), Domain::Unbounded | Domain::Wall);
        Ok(Self {
            scale: *scale,
            source: Source::new(scene, scale, &surfaced, &tags)?,
            far_field: is_truncated.then(|| FarField::new(scene, scale)),
            surfaced,
            tags,
            deforming_joints: match scene.deforms() {
                true => scene.articulation().joints().len(),
                false => 0,
            },
            geometry: scene.fem().geometry,
            mesher: scene.fem().mesher,
            symmetry_planes: scene.fem_symmetry_planes(),
            sizes: None,
            coarsening: 1.0,
        })
    }

    /// The same with all element sizes multiplied by a factor, on bodies and in the fluid.
    ///
    /// A factor on the sizes on bodies alone, such as `fem.size_factor`, hardly changes large
    /// elements far from them, because their growth is limited.
    pub fn coarsened(mut self, factor: f64) -> Self {
        self.coarsening = factor;
        self
    }

    /// Moves and turns bodies onto the symmetry planes that they are off by rounding errors only.
    pub fn snap_to_symmetry_planes(&self, poses: &mut [Isometry3<f64>]) {
        let snap = |x: &mut f64| {
            if x.abs() <= PLANE_ROUNDING {
                *x = 0.0;
            }
        };
        for pose in poses {
            let rotation = pose.rotation.into_inner();
            let mut snapped = rotation;
            for axis in (0..3).filter(|&axis| self.symmetry_planes[axis]) {
                snap(&mut pose.translation.vector[axis]);
                // Rotations keep the plane if they are about its normal.
                let others = (0..3).filter(|other| *other != axis);
                others.for_each(|other| snap(&mut snapped.coords[other]));
            }
            if snapped != rotation {
                pose.rotation = UnitQuaternion::new_normalize(snapped);
            }
        }
    }

    /// Names of the boundary parts of the bodies with surfaces.
    pub fn tags(&self) -> impl Iterator<Item = &str> {
        self.surfaced.iter().map(|s| self.tags[s.body].as_str())
    }

    /// Whether the fluid is bounded by the plane wall `z = 0`.
    fn has_plane_wall(&self) -> bool {
        self.far_field.is_some_and(|far| far.has_plane_wall())
    }

    /// Names of the boundary parts that are walls.
    pub fn wall_tags(&self) -> Vec<&str> {
        match &self.source {
            Source::Generated(_) if self.has_plane_wall() => vec![Container::TAG, PLANE_WALL],
            Source::Generated(_) | Source::Cylinder(_) => vec![Container::TAG],
            Source::File { walls, .. } => walls.iter().map(String::as_str).collect(),
        }
    }

    /// Placement of the bodies with surfaces, from that of all bodies.
    pub fn placement(&self, all: &Placement) -> Placement {
        Placement {
            poses: self.surfaced.iter().map(|s| all.poses[s.body]).collect(),
            values: all.values.clone(),
        }
    }

    /// Surfaces of the bodies.
    fn surfaces(&self, placement: &Placement) -> Vec<Box<dyn Surface>> {
        let surface = |(s, pose): (&Surfaced, &Isometry3<f64>)| match &s.deformation {
            None => self.scale.surface(&s.shape, pose),
            Some(of) => of.surface(&placement.values, pose, self.scale.length(1.0)),
        };
        let placed = self.surfaced.iter().zip(&placement.poses);
        placed.filter_map(surface).collect()
    }

    /// Scaled displacement of the surface of a body that deforms from its shape at some values of
    /// the joints to that at others, near points relative to its centre and in its axes.
    pub fn displacement(
        &self,
        deformation: &Deformation,
        [from, to]: [&[f64]; 2],
    ) -> impl Fn(&Vector3<f64>) -> Vector3<f64> + use<> {
        let ([from, to], unit) = (
            [from, to].map(|values| deformation.at(values)),
            self.scale.length(1.0),
        );
        move |x| unit * from.displacement(&to, &(x / unit))
    }

    /// Smooth surfaces on the boundary of the fluid, with the names of their boundary parts.
    pub fn boundary_surfaces(&self, placement: &Placement) -> Vec<(&str, Box<dyn Surface>)> {
        let wall: Option<(&str, Box<dyn Surface>)> = match &self.source {
            Source::Generated(Container::Ball(ball)) => Some((Container::TAG, Box::new(*ball))),
            Source::Generated(Container::Surface(surface)) => {
                Some((Container::TAG, Box::new(surface.clone())))
            }
            // Boxes are flat, ends of cylinders are not physical walls, and the exact shape of
            // walls in a file is not known.
            Source::Generated(_) | Source::Cylinder(_) | Source::File { .. } => None,
        };
        let bodies = self
            .tags()
            .zip(self.surfaces(placement))
            .zip(&self.surfaced);
        // Parts of a file's boundary have no other shape than the file's.
        let known = bodies.filter(|(_, s)| !s.shape.is_mesh_part());
        known.map(|(named, _)| named).chain(wall).collect()
    }

    /// Balls about the centres of the bodies that contain them.
    pub fn bounding_balls(&self, placement: &Placement) -> Vec<Sphere> {
        let bounding = |of: &Deformation| self.scale.length(of.bounding_radius(&placement.values));
        (self.surfaced.iter().zip(&placement.poses))
            .map(|(s, pose)| Sphere {
                centre: pose.translation.vector,
                radius: s.deformation.as_ref().map_or(s.radius, bounding),
            })
            .collect()
    }

    /// Container of the fluid around the bodies; `None` for the mesh of a file.
    fn container(&self, placement: &Placement) -> Option<Container> {
        match &self.source {
            Source::Generated(container) => Some(container.clone()),
            Source::Cylinder(radius) => Some(Container::Capsule(cylinder::capsule_around(
                *radius,
                &self.bounding_balls(placement),
            ))),
            Source::File { .. } => None,
        }
    }

    /// The part of a cylinder that a new mesh around the bodies fills.
    pub fn capsule(&self, placement: &Placement) -> Option<Capsule> {
        match self.container(placement) {
            Some(Container::Capsule(capsule)) => Some(capsule),
            _ => None,
        }
    }

    /// Prescribes element sizes for new meshes: edge lengths at positions.
    ///
    /// The positions are those of a mesh of a placement. Equal bodies with equal
    /// orientations get equal meshes: the sizes near one of them are prescribed at all of them.
    ///
    /// # Errors
    /// Sizes that are not positive.
    pub fn adapt(
        &mut self,
        placement: &Placement,
        mut sizes: Vec<(Vector3<f64>, f64)>,
    ) -> Result<(), ModelError> {
        let placed: Vec<_> = self.surfaced.iter().zip(&placement.poses).collect();
        for k in 0..sizes.len() {
            let (position, size) = sizes[k];
            for (s, pose) in &placed {
                let centre = pose.translation.vector;
                if (position - centre).norm() > 2.0 * s.radius {
                    continue;
                }
                for (other, other_pose) in &placed {
                    let is_turned = pose.rotation != other_pose.rotation;
                    if other.body != s.body
                        && (&other.shape, other.size) == (&s.shape, s.size)
                        && other.deformation == s.deformation
                        && (s.is_isotropic() || !is_turned)
                    {
                        sizes.push((position - centre + other_pose.translation.vector, size));
                    }
                }
            }
        }
        self.sizes = Some(SizeMap::new(sizes, ADAPTED_GROWTH)?);
        Ok(())
    }

    /// Largest length of cells in gaps, relative to the width of their gap
    /// ([`TetMesh::gap_ratio`]).
    pub fn gap_ratio(&self, mesh: &TetMesh, placement: &Placement) -> f64 {
        let surfaces = self.surfaces(placement);
        let surfaces: Vec<&dyn Surface> = surfaces.iter().map(|s| &**s).collect();
        let container = self.container(placement);
        mesh.gap_ratio(&surfaces, container.as_ref().map(Container::surface))
    }

    /// Twice the permeability of each cell: `2 h^2 / 12` in a gap of width `h`.
    ///
    /// `None` if no gap between the placed bodies, or between a body and the wall, is narrow.
    pub fn permeability(&self, mesh: &TetMesh, placement: &Placement) -> Option<Vec<f64>> {
        let (surfaces, balls) = (self.surfaces(placement), self.bounding_balls(placement));
        let container = self.container(placement);
        let wall = container.as_ref().map(Container::surface);
        let narrow = |gap: f64, radius: f64| gap < NARROW_GAP * radius;
        // Gaps to the balls are lower bounds.
        let is_near_others = |(k, a): (usize, &Sphere)| {
            surfaces[..k].iter().zip(&balls).any(|(b, ball)| {
                let gap = b.signed_distance(a.centre) - a.radius;
                narrow(gap, a.radius.min(ball.radius))
            })
        };
        let is_near_wall = |a: &Sphere| {
            wall.is_some_and(|wall| narrow(-wall.signed_distance(a.centre) - a.radius, a.radius))
        };
        let is_narrow =
            balls.iter().enumerate().any(is_near_others) || balls.iter().any(is_near_wall);
        is_narrow.then(|| {
            let surfaces: Vec<&dyn Surface> = surfaces.iter().map(|s| &**s).collect();
            let widths = mesh.gap_widths(&surfaces, wall);
            widths.into_iter().map(|h| h * h / 6.0).collect()
        })
    }

    /// Generates a mesh around the placed bodies.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    pub fn generate(&self, placement: &Placement) -> Result<TetMesh, ModelError> {
        let surfaces = self.surfaces(placement);
        let in_scene = |error| self.scale.error_to_scene(error);
        if let Source::File { mesh, .. } = &self.source {
            let bodies = self.surfaced.iter().zip(self.tags());
            let moved: Vec<_> = (bodies.zip(placement.poses.iter().zip(&surfaces)))
                .map(|((body, name), (pose, surface))| MovedBody {
                    name,
                    motion: body.motion(pose),
                    surface: Some((&**surface, body.size)),
                })
                .collect();
            let mesh = mesh_file::remesh(mesh, &moved, self.geometry, self.mesher);
            return Ok(mesh.map_err(in_scene)?);
        }
        let Some(container) = &self.container(placement) else {
            return Err(ModelError::NoMesh);
        };
        let bodies: Vec<MeshedBody> = self
            .surfaced
            .iter()
            .zip(self.tags())
            .zip(&surfaces)
            .map(|((s, name), surface)| MeshedBody {
                name,
                surface: &**surface,
                size: self.coarsening * s.size_at(&placement.values),
            })
            .collect();
        let finest = self
            .surfaced
            .iter()
            .map(|s| s.relative_size)
            .fold(f64::INFINITY, f64::min);
        let mut parameters = GenerateParams::default();
        parameters.growth = (self.coarsening * growth(finest)).min(MAX_COARSE_GROWTH);
        parameters.symmetry_planes = self.symmetry_planes;
        // The half of the ball above the wall is that above a symmetry plane.
        parameters.symmetry_planes[2] |= self.has_plane_wall();
        let generated = match &self.sizes {
            None => mesher::generate(&bodies, container, &parameters),
            Some(sizes) => {
                parameters.growth = ADAPTED_GROWTH;
                mesher::generate_sized(&bodies, container, &parameters, &|x| sizes.at(x))
            }
        };
        let mut tets = generated.map_err(in_scene)?.mesh;
        if self.has_plane_wall() {
            for tag in tets
                .tags
                .iter_mut()
                .filter(|tag| **tag == SYMMETRY_PLANE_TAGS[2])
            {
                *tag = PLANE_WALL.to_owned();
            }
        }
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
