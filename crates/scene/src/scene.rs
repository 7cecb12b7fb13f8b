//! A scene: fluid, domain, bodies, links, gait and how to compute them.

use std::path::PathBuf;

use nalgebra::{Isometry3, Vector3};
use rigid::{Articulation, BodyKind, State};

use crate::document::Document;
use crate::error::SceneError;
use crate::gait::Gait;
use crate::shape::Shape;
use crate::words::{
    DomainKind, EstimatesKind, FormulationKind, GeometryKind, MeshMotionKind, MirrorKind,
    ModelKind, SolverKind,
};

/// A scene that passed all checks: fluid, domain, bodies, links, gait and how to compute them.
///
/// Lengths, times, forces and viscosity are in the scene's own units.
///
/// ```
/// let scene = scene::Scene::parse(
///     r#"
///     domain = { kind = "ball", radius = 10 }
///     [[bodies]]
///     name = "ball"
///     radius = 1
///     position = [0, 0, 0]
///     force = [1, 0, 0]
///     "#,
/// )?;
/// assert_eq!(scene.bodies[0].name, "ball");
/// assert_eq!(scene.viscosity, 1.0);
/// # Ok::<(), scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name: the file's name without its ending.
    pub name: String,
    /// Dynamic viscosity.
    pub viscosity: f64,
    /// Where the fluid is.
    pub domain: Domain,
    /// The bodies.
    pub bodies: Vec<Body>,
    /// Bodies and links as one articulated set, in the order of the file.
    pub articulation: Articulation,
    /// How the links' lengths change.
    pub gait: Gait,
    /// How the flow is modelled.
    pub model: ModelOptions,
    /// Options of the finite-element model.
    pub fem: FemOptions,
    pub(crate) document: Document,
}

/// Where the fluid is.
#[derive(Clone, Debug, PartialEq)]
pub enum Domain {
    /// Everywhere.
    Unbounded,
    /// In a ball about the origin, with no slip on its surface.
    Ball {
        /// Radius.
        radius: f64,
    },
    /// In a box about the origin, with no slip on its faces.
    Box {
        /// Edge lengths.
        size: Vector3<f64>,
    },
    /// In an infinite circular cylinder about the x axis.
    Cylinder {
        /// Radius.
        radius: f64,
    },
    /// Above the wall z = 0.
    Wall,
    /// In the volume of a mesh.
    Mesh {
        /// The Gmsh file, found from the scene's folder.
        file: PathBuf,
        /// Names of the parts of its boundary where the fluid does not slip.
        walls: Vec<String>,
    },
}

/// A body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its name.
    pub name: String,
    /// Its shape.
    pub shape: Shape,
    /// Its centre at the start.
    pub position: Vector3<f64>,
    /// Name of its part of the mesh's boundary, when the domain is a mesh.
    pub surface: Option<String>,
    /// External force.
    pub force: Vector3<f64>,
    /// External torque about the centre.
    pub torque: Vector3<f64>,
    /// Whether it is held still, as an obstacle.
    pub fixed: bool,
    /// Mass; zero when inertia is left out.
    pub mass: f64,
    /// Moment of inertia about the centre; zero when inertia is left out.
    pub inertia: f64,
}

/// How the flow is modelled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelOptions {
    /// The model.
    pub kind: ModelKind,
    /// Relative error asked of the net displacement of a cycle.
    pub tolerance: f64,
}

/// Options of the finite-element model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FemOptions {
    /// How the links are imposed.
    pub formulation: FormulationKind,
    /// How the systems are solved.
    pub solver: SolverKind,
    /// Number of subdomains of additive Schwarz.
    pub subdomains: u32,
    /// Layers of overlap of additive Schwarz.
    pub overlap: u32,
    /// True relative residual at which a solve stops.
    pub rtol: f64,
    /// Element size on the bodies' surfaces; chosen by the model when absent.
    pub surface_size: Option<f64>,
    /// Factor on the element sizes of all bodies.
    pub size_factor: Option<f64>,
    /// Relative error by the mesh that is asked for; where no factor on sizes is given, meshes are refined until they meet it.
    pub target: Option<f64>,
    /// Whether errors by the mesh are estimated.
    pub estimates: EstimatesKind,
    /// Shape of the elements at the bodies.
    pub geometry: GeometryKind,
    /// How the mesh follows the bodies.
    pub mesh_motion: MeshMotionKind,
    /// Whether mirror planes are looked for.
    pub mirror: MirrorKind,
}

impl Scene {
    /// File and line of a key such as `bodies[1].radius`, for messages.
    pub fn place(&self, key: &str) -> String {
        self.document.place(key)
    }

    /// Refuses a scene without a gait to run.
    ///
    /// # Errors
    /// [`SceneError::NotApplicable`].
    pub fn require_gait(&self) -> Result<(), SceneError> {
        if !self.gait.phases.is_empty() {
            return Ok(());
        }
        Err(SceneError::NotApplicable {
            place: self.place("gait"),
            problem: "the scene has no [[gait.phases]] to run; add phases, or use `swim solve` for one instant"
                .to_owned(),
        })
    }

    /// The state in which the scene starts.
    pub fn initial_state(&self) -> State {
        self.articulation.initial_state()
    }

    /// The first body that is a spheroid.
    pub fn first_spheroid(&self) -> Option<usize> {
        self.bodies
            .iter()
            .position(|body| matches!(body.shape, Shape::Spheroid { .. }))
    }

    /// Numbers of the bodies that are held still.
    pub fn fixed_bodies(&self) -> Vec<usize> {
        (0..self.bodies.len())
            .filter(|&body| self.bodies[body].fixed)
            .collect()
    }

    /// Whether something outside acts on the bodies.
    pub fn has_loads(&self) -> bool {
        self.bodies
            .iter()
            .any(|body| body.force != Vector3::zeros() || body.torque != Vector3::zeros())
    }

    /// Whether the bodies' motion depends on their shape alone: one linkage, nothing around it, nothing pulling.
    pub fn is_free(&self) -> bool {
        self.domain == Domain::Unbounded
            && !self.has_loads()
            && self.articulation.linkages().len() == 1
    }
}

impl Body {
    /// Radius of the smallest ball about the centre that holds the body; zero for points.
    pub fn bounding_radius(&self) -> f64 {
        self.shape.bounding_radius()
    }

    /// What the body is to the links.
    pub fn kind(&self) -> BodyKind {
        match self.shape {
            Shape::Sphere { .. } | Shape::Spheroid { .. } => BodyKind::Rigid,
            Shape::Point => BodyKind::Point,
        }
    }
}

impl Domain {
    /// The kind, as the scene file names it.
    pub fn kind(&self) -> DomainKind {
        match self {
            Self::Unbounded => DomainKind::Unbounded,
            Self::Ball { .. } => DomainKind::Ball,
            Self::Box { .. } => DomainKind::Box,
            Self::Cylinder { .. } => DomainKind::Cylinder,
            Self::Wall => DomainKind::Wall,
            Self::Mesh { .. } => DomainKind::Mesh,
        }
    }

    /// Room between a body and the nearest wall, negative where it is outside; infinite where no wall is known.
    ///
    /// The distance for spheres; for spheroids at most the distance.
    pub fn room(&self, body: &Body, pose: &Isometry3<f64>) -> f64 {
        let (centre, attitude) = (&pose.translation.vector, &pose.rotation);
        let reach = |direction: &Vector3<f64>| body.shape.reach(attitude, direction);
        match self {
            Self::Unbounded | Self::Mesh { .. } => f64::INFINITY,
            Self::Ball { radius } => radius - centre.norm() - body.bounding_radius(),
            Self::Box { size } => {
                let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
                let reaches = Vector3::from(axes.map(|axis| reach(&axis)));
                (size / 2.0 - centre.abs() - reaches).min()
            }
            Self::Cylinder { radius } => {
                let widest = body.shape.reach_across(attitude, &Vector3::x());
                radius - centre.yz().norm() - widest
            }
            Self::Wall => centre.z - reach(&Vector3::z()),
        }
    }
}
