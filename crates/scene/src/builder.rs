//! Scenes built by a program.

use std::collections::BTreeMap;
use std::sync::Arc;

use rigid::{Joint, JointDrive, JointKind};

use crate::document::Document;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::keys::{BodyFile, FemOptions, HarmonicFile, JointFile, LoadFile, PhaseFile, SceneFile};
use crate::material_motion::MaterialMotion;
use crate::nearest::Names;
use crate::scene::Scene;
use crate::shape::Shape;
use crate::shapes::{PointShape, SpheroidShape};
use crate::words::{ArmsKind, ModelKind};
use crate::write::{domain_file, joint_file};

/// Replaces the file name in messages about a scene that a program builds.
const ORIGIN: &str = "scene built by a program";

/// Builds a scene step by step; [`SceneBuilder::build`] makes the same checks as for a file.
///
/// Options that are not set have the defaults of the scene file.
///
/// ```
/// use scene::{ModelKind, Scene};
///
/// let scene = Scene::builder()
///     .ball(40.0)
///     .sphere("left", 1.0, [-10.0, 0.0, 0.0])
///     .sphere("right", 1.0, [0.0, 0.0, 0.0])
///     .force("left", [0.0, 0.0, 1.0])
///     .slide("arm", "left", "right")
///     .phase("arm", 6.0, 1.0)
///     .phase("arm", 10.0, 1.0)
///     .model(ModelKind::Fem)
///     .build()?;
/// assert_eq!(scene.gait().duration(), 2.0);
///
/// let error = Scene::builder().sphere("a", -1.0, [0.0; 3]).build().unwrap_err();
/// assert!(error.to_string().contains("bodies[0].radius must be a number greater than zero"));
/// # Ok::<(), scene::SceneError>(())
/// ```
#[must_use]
#[derive(Clone, Debug, Default)]
pub struct SceneBuilder {
    name: Option<String>,
    file: SceneFile,
    /// Settings of bodies by name; they are applied when all bodies are known.
    of_bodies: Vec<(String, BodySetting)>,
    motions: BTreeMap<String, Arc<dyn MaterialMotion>>,
}

/// A key of a body.
#[derive(Clone, Debug)]
enum BodySetting {
    Force([f64; 3]),
    Torque([f64; 3]),
    Velocity([f64; 3]),
    AngularVelocity([f64; 3]),
    Fixed,
    Surface(String),
    Mass { mass: f64, inertia: f64 },
}

impl Scene {
    /// Starts a scene without bodies in unbounded fluid.
    pub fn builder() -> SceneBuilder {
        SceneBuilder::default()
    }
}

impl SceneBuilder {
    /// Names the scene; the default is `scene`.
    pub fn name(mut self, name: &str) -> Self {
        self.name = Some(name.to_owned());
        self
    }

    /// Sets the dynamic viscosity.
    pub fn viscosity(mut self, viscosity: f64) -> Self {
        self.file.fluid.viscosity = viscosity;
        self
    }

    /// Sets the region that the fluid fills.
    ///
    /// A relative path of a mesh starts at the current folder.
    pub fn domain(mut self, domain: &Domain) -> Self {
        self.file.domain = domain_file(domain);
        self
    }

    /// Encloses the fluid in a ball centred at the origin.
    pub fn ball(self, radius: f64) -> Self {
        self.domain(&Domain::Ball { radius })
    }

    /// Adds a sphere.
    pub fn sphere(self, name: &str, radius: f64, centre: [f64; 3]) -> Self {
        self.shaped(name, Shape::sphere(radius), centre)
    }

    /// Adds a spheroid; `radius` is that of the equator, `axis` the axis of revolution.
    pub fn spheroid(
        self,
        name: &str,
        radius: f64,
        half_length: f64,
        axis: [f64; 3],
        centre: [f64; 3],
    ) -> Self {
        let spheroid = SpheroidShape {
            radius,
            half_length,
            axis: axis.into(),
        };
        self.shaped(name, spheroid.into(), centre)
    }

    /// Adds a body of any shape; lengths and directions are those of the initial configuration.
    pub fn shaped(mut self, name: &str, shape: Shape, centre: [f64; 3]) -> Self {
        self.file.bodies.push(BodyFile {
            name: Some(name.to_owned()),
            position: Some(centre),
            ..shape.to_keys()
        });
        self
    }

    /// Adds a massless point, at which joints meet.
    pub fn point(self, name: &str, position: [f64; 3]) -> Self {
        self.shaped(name, PointShape.into(), position)
    }

    /// Applies an external force to a body.
    pub fn force(self, body: &str, force: [f64; 3]) -> Self {
        self.set_of_body(body, BodySetting::Force(force))
    }

    /// Applies an external torque about the centre of a body.
    pub fn torque(self, body: &str, torque: [f64; 3]) -> Self {
        self.set_of_body(body, BodySetting::Torque(torque))
    }

    /// Gives a body a velocity of its centre; the force that drives it is a result.
    pub fn velocity(self, body: &str, velocity: [f64; 3]) -> Self {
        self.set_of_body(body, BodySetting::Velocity(velocity))
    }

    /// Gives a body an angular velocity; the torque that drives it is a result.
    pub fn angular_velocity(self, body: &str, angular_velocity: [f64; 3]) -> Self {
        self.set_of_body(body, BodySetting::AngularVelocity(angular_velocity))
    }

    /// Fixes a body in space: an obstacle, or a body that holds a swimmer.
    pub fn fixed(self, body: &str) -> Self {
        self.set_of_body(body, BodySetting::Fixed)
    }

    /// Names a body's part of the boundary of a mesh.
    pub fn surface(self, body: &str, surface: &str) -> Self {
        self.set_of_body(body, BodySetting::Surface(surface.to_owned()))
    }

    /// Gives a body a mass and a moment of inertia, for time stepping with inertia.
    pub fn mass(self, body: &str, mass: f64, inertia: f64) -> Self {
        self.set_of_body(body, BodySetting::Mass { mass, inertia })
    }

    /// Deforms a body with the surface of a file by a motion of its vertices.
    ///
    /// The gait names the coordinates of the motion `BODY.NAME`. No file can contain such a scene:
    /// `swimmer::simulate` writes none.
    pub fn deformation(mut self, body: &str, motion: Arc<dyn MaterialMotion>) -> Self {
        self.motions.insert(body.to_owned(), motion);
        self
    }

    fn set_of_body(mut self, body: &str, setting: BodySetting) -> Self {
        self.of_bodies.push((body.to_owned(), setting));
        self
    }

    /// Connects `body` to the body `to` by an arm; the initial distance is the initial length.
    pub fn slide(self, name: &str, body: &str, to: &str) -> Self {
        self.joint(name, body, to, JointKind::Slide, JointDrive::Prescribed)
    }

    /// Connects `body` to the body `to` by any joint, given in the pose of the bodies' positions.
    pub fn joint(
        mut self,
        name: &str,
        body: &str,
        to: &str,
        kind: JointKind,
        drive: JointDrive,
    ) -> Self {
        // The numbers of the bodies are not known yet; their names count.
        let joint = Joint::slide(name, 0, 0).with_kind(kind).with_drive(drive);
        self.file.links.push(JointFile {
            body: Some(body.to_owned()),
            to: Some(to.to_owned()),
            ..joint_file(&joint)
        });
        self
    }

    /// Adds a phase of the gait, at the end of which a joint has the given value.
    pub fn phase(self, joint: &str, length: f64, duration: f64) -> Self {
        self.any_phase(PhaseFile {
            link: Some(joint.to_owned()),
            length: Some(length),
            duration,
            ..PhaseFile::default()
        })
    }

    /// Adds a phase of the gait in which several joints change their values at the same time.
    pub fn targets(self, changes: &[(&str, f64)], duration: f64) -> Self {
        let targets = changes
            .iter()
            .map(|&(joint, length)| (joint.to_owned(), length));
        self.any_phase(PhaseFile {
            targets: Some(targets.collect()),
            duration,
            ..PhaseFile::default()
        })
    }

    /// Adds a term `amplitude sin(2 π order t / period + phase)` to the value of a joint.
    ///
    /// All terms have the period given last.
    pub fn harmonic(
        mut self,
        joint: &str,
        amplitude: f64,
        phase: f64,
        order: u32,
        period: f64,
    ) -> Self {
        let gait = &mut self.file.gait;
        gait.period = Some(period);
        gait.harmonics.get_or_insert_default().push(HarmonicFile {
            link: Some(joint.to_owned()),
            mean: None,
            amplitude: Some(amplitude),
            phase,
            order,
            ..HarmonicFile::default()
        });
        self
    }

    /// Adds a phase of the gait in which all values are constant.
    pub fn pause(self, duration: f64) -> Self {
        self.any_phase(PhaseFile {
            duration,
            ..PhaseFile::default()
        })
    }

    fn any_phase(mut self, phase: PhaseFile) -> Self {
        self.file.gait.phases.get_or_insert_default().push(phase);
        self
    }

    /// Sets the number of times that the phases are repeated.
    pub fn cycles(mut self, cycles: u32) -> Self {
        self.file.gait.cycles = cycles;
        self
    }

    /// Starts passive joints from the values of the periodic state.
    pub fn periodic(mut self) -> Self {
        self.file.gait.periodic = true;
        self
    }

    /// Sets the way in which bodies are attached to arms that rotate.
    pub fn arms(mut self, arms: ArmsKind) -> Self {
        self.file.gait.arms = arms;
        self
    }

    /// Sets the model of the flow.
    pub fn model(mut self, kind: ModelKind) -> Self {
        self.file.model.kind = kind;
        self
    }

    /// Sets the tolerated relative error of the net displacement per cycle.
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.file.model.tolerance = tolerance;
        self
    }

    /// Sets the options of the finite-element model.
    pub fn fem(mut self, fem: FemOptions) -> Self {
        self.file.fem = fem;
        self
    }

    /// Checks the scene.
    ///
    /// # Errors
    /// As [`Scene::read`], with keys of the scene file instead of lines.
    pub fn build(mut self) -> Result<Scene, SceneError> {
        for (name, setting) in std::mem::take(&mut self.of_bodies) {
            let body = self.find_body(&name)?;
            match setting {
                BodySetting::Force(force) => body.force = LoadFile::Constant(force),
                BodySetting::Torque(torque) => body.torque = Some(LoadFile::Constant(torque)),
                BodySetting::Velocity(velocity) => {
                    body.velocity = Some(LoadFile::Constant(velocity));
                }
                BodySetting::AngularVelocity(velocity) => {
                    body.angular_velocity = Some(LoadFile::Constant(velocity));
                }
                BodySetting::Fixed => body.fixed = true,
                BodySetting::Surface(surface) => body.surface = Some(surface),
                BodySetting::Mass { mass, inertia } => {
                    body.mass = mass;
                    body.inertia = inertia;
                }
            }
        }
        let motions = std::mem::take(&mut self.motions);
        for body in motions.keys() {
            self.find_body(body)?;
        }
        let document = Document::from_values(&self.file, ORIGIN)?.with_motions(motions);
        let mut scene = Scene::from_document(document)?;
        scene.name = self.name.unwrap_or_else(|| "scene".to_owned());
        Ok(scene)
    }

    fn find_body(&mut self, name: &str) -> Result<&mut BodyFile, SceneError> {
        let bodies = &mut self.file.bodies;
        let names = bodies.iter().filter_map(|body| body.name.as_deref());
        match Names::new("body", names).find(name) {
            // Every body of a builder has a name, so that the positions are those in the list.
            Ok(position) => Ok(&mut bodies[position]),
            Err(problem) => Err(SceneError::BadValue {
                place: ORIGIN.to_owned(),
                key: "bodies".to_owned(),
                problem,
            }),
        }
    }
}
