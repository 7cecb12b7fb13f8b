//! A scene: fluid, domain, bodies, joints, gait, and the options of the computation.

use std::borrow::Cow;

use nalgebra::{Isometry3, Vector3};
use rheology::Law;
use rigid::{Articulation, Constraints, ExternalLoad, JointDrive, JointKind, RigidError, State};

use crate::body::{Body, volume_problem, with_held_velocities};
use crate::contact::Repulsion;
use crate::deformation::Deformation;
use crate::document::Document;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::flow::Background;
use crate::gait::Gait;
use crate::gait_table::GaitTable;
use crate::keys::{
    FemOptions, JointValues, LearnOptions, ModelOptions, OptimiseOptions, OutputOptions,
};
use crate::loads::VectorOscillation;
use crate::read::limits::by_joint;
use crate::shape::Shape;
use crate::shape_path::JointForce;
use crate::surface_shape::SourceFile;
use crate::thermal_noise::ThermalNoise;
use crate::words::{InertiaKind, RheologyKind, StartKind};

/// Largest number of joints that are named one by one, and number of the first ones of more.
const MAX_NAMES: usize = 8;
const FIRST_NAMES: usize = 3;

/// Inertia of the fluid and of the bodies in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FluidInertia {
    /// Terms of the momentum equation.
    pub kind: InertiaKind,
    /// Flow at the start.
    pub start: StartKind,
    /// Length of all steps; `None` if their errors choose them.
    pub time_step: Option<f64>,
}

impl FluidInertia {
    /// Whether the fluid has inertia; not for [`InertiaKind::Auto`], which begins without.
    pub fn is_kept(&self) -> bool {
        matches!(self.kind, InertiaKind::Unsteady | InertiaKind::Full)
    }
}

/// Viscosity law of a fluid that is not Newtonian.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rheology {
    /// Viscosity as a function of the shear rate, in the scene's units.
    pub law: Law,
    /// Whether flows follow the law.
    pub kind: RheologyKind,
}

impl Rheology {
    /// Whether flows follow the law; not for [`RheologyKind::Auto`], which begins without.
    pub fn is_kept(&self) -> bool {
        self.kind == RheologyKind::Full
    }
}

/// A scene that passed all checks: fluid, domain, bodies, joints, gait and options.
///
/// The fields are private, so that a scene stays checked: methods such as [`Scene::with_fem`] check
/// the values that they change.
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
/// assert_eq!(scene.bodies()[0].name, "ball");
/// assert_eq!(scene.viscosity(), 1.0);
/// # Ok::<(), scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    pub(crate) name: String,
    pub(crate) viscosity: f64,
    pub(crate) rheology: Option<Rheology>,
    /// Density of the fluid, for the buoyancy and the inertia.
    pub(crate) density: f64,
    pub(crate) inertia: FluidInertia,
    pub(crate) noise: Option<ThermalNoise>,
    pub(crate) gravity: Vector3<f64>,
    pub(crate) background: Option<Background>,
    pub(crate) domain: Domain,
    pub(crate) bodies: Vec<Body>,
    pub(crate) articulation: Articulation,
    /// The magnetic field.
    pub(crate) field: Option<VectorOscillation>,
    /// The repulsion between surfaces that nearly touch.
    pub(crate) repulsion: Option<Repulsion>,
    /// Forces on passive joints that oscillate.
    pub(crate) joint_forces: Vec<JointForce>,
    pub(crate) gait: Gait,
    pub(crate) starts_periodic: bool,
    /// The table that the gait is from.
    pub(crate) gait_table: Option<GaitTable>,
    pub(crate) model: ModelOptions,
    pub(crate) fem: FemOptions,
    pub(crate) optimise: OptimiseOptions,
    pub(crate) learn: LearnOptions,
    pub(crate) output: OutputOptions,
    /// The surfaces and meshes that were read.
    pub(crate) sources: Vec<SourceFile>,
    pub(crate) document: Document,
}

impl Scene {
    /// Name: the file's name without its extension.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Dynamic viscosity; that at rest, or the consistency, of a fluid that is not Newtonian.
    pub fn viscosity(&self) -> f64 {
        self.viscosity
    }

    /// Viscosity law; `None` for a Newtonian fluid.
    pub fn rheology(&self) -> Option<&Rheology> {
        self.rheology.as_ref()
    }

    /// Bodies with flat facets from files, with the relative difference of their size from that of
    /// the smooth surface through their vertices ([`mesher::TriangulatedSurface::smooth_size`]).
    ///
    /// It estimates what no error bar contains: the relative change of forces if the facets stand
    /// for a smooth surface. Bodies that deform have it before the deformation.
    pub fn facet_errors(&self) -> Vec<(usize, f64)> {
        let error = |(number, body): (usize, &Body)| match &body.shape {
            Shape::Surface(shape) => {
                let size = shape.shape.surface.smooth_size()?;
                Some((number, size.recip() - 1.0))
            }
            _ => None,
        };
        self.bodies.iter().enumerate().filter_map(error).collect()
    }

    /// Viscosity law that flows follow; `None` if they have a constant viscosity.
    pub fn viscosity_law(&self) -> Option<&Law> {
        let kept = self.rheology.as_ref().filter(|rheology| rheology.is_kept());
        kept.map(|rheology| &rheology.law)
    }

    /// Density of the fluid; zero by default.
    pub fn fluid_density(&self) -> f64 {
        self.density
    }

    /// Inertia of the fluid.
    pub fn inertia(&self) -> &FluidInertia {
        &self.inertia
    }

    /// Thermal noise of the fluid; `None` without one.
    pub fn noise(&self) -> Option<&ThermalNoise> {
        self.noise.as_ref()
    }

    /// Acceleration of gravity; zero by default.
    pub fn gravity(&self) -> Vector3<f64> {
        self.gravity
    }

    /// Flow in the absence of the bodies; `None` for fluid at rest.
    pub fn background(&self) -> Option<&Background> {
        self.background.as_ref()
    }

    /// Whether the mean flow through the periodic box is a result, because its pressure gradient is
    /// given; otherwise the mean flow is given, and the pressure gradient is a result.
    pub fn finds_mean_flow(&self) -> bool {
        matches!(self.background, Some(Background::PressureGradient { .. }))
    }

    /// Magnetic field in which bodies with a moment are; `None` without one.
    pub fn field(&self) -> Option<&VectorOscillation> {
        self.field.as_ref()
    }

    /// Repulsion between surfaces that nearly touch; `None` without one.
    pub fn repulsion(&self) -> Option<&Repulsion> {
        self.repulsion.as_ref()
    }

    /// Whether surfaces have velocities relative to their bodies or to the fluid: slip of some
    /// body, or a background flow.
    ///
    /// Velocities at a constant shape are then not zero.
    pub fn has_surface_velocity(&self) -> bool {
        self.background.is_some() || self.has_slip()
    }

    /// Whether the surfaces of some bodies slip.
    pub fn has_slip(&self) -> bool {
        self.bodies.iter().any(|body| body.slip.is_some())
    }

    /// Whether some bodies deform.
    ///
    /// Velocities are then those of the rates of all shape coordinates, of joints and deformations.
    pub fn deforms(&self) -> bool {
        self.bodies.iter().any(|body| body.deformation.is_some())
    }

    /// The joints that are coordinates of deformations with a period, which changes no shape:
    /// phases of waves, and periodic frames.
    pub fn periodic_coordinates(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let deformations = self
            .bodies
            .iter()
            .filter_map(|body| body.deformation.as_ref());
        deformations.flat_map(Deformation::periods)
    }

    /// The bodies at these values of the joints: of those that deform, the
    /// [outlines](Deformation::outline).
    pub fn bodies_at(&self, values: &[f64]) -> Cow<'_, [Body]> {
        if !self.deforms() {
            return Cow::Borrowed(&self.bodies);
        }
        let at = |body: &Body| body.at(values).into_owned();
        Cow::Owned(self.bodies.iter().map(at).collect())
    }

    /// Refuses values of the joints at which a body cannot be: a radius that is not positive, a
    /// surface that folds.
    ///
    /// # Errors
    /// [`SceneError::NotApplicable`] with the name of the body.
    pub fn check_deformations(&self, values: &[f64]) -> Result<(), SceneError> {
        for (number, body) in self.bodies.iter().enumerate() {
            let deformation = body.deformation.as_ref();
            if let Some(problem) = deformation.and_then(|of| of.problem(values)) {
                return Err(SceneError::NotApplicable {
                    place: self.place(&format!("bodies[{number}].deformation")),
                    problem: format!("the body '{}' {problem}", body.name),
                });
            }
        }
        Ok(())
    }

    /// Refuses rates of the joints at which the volume of the bodies changes in a container.
    ///
    /// # Errors
    /// [`SceneError::NotApplicable`] with the rate.
    pub fn check_volume_rate(&self, values: &[f64], rates: &[f64]) -> Result<(), SceneError> {
        if !self.domain.keeps_volume() {
            return Ok(());
        }
        match volume_problem(&self.bodies, values, rates) {
            None => Ok(()),
            Some(problem) => Err(SceneError::NotApplicable {
                place: self.place("domain.kind"),
                problem,
            }),
        }
    }

    /// Region that the fluid fills.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Bodies, in the order of the file.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Bodies and joints as one articulation, in the order of the file.
    pub fn articulation(&self) -> &Articulation {
        &self.articulation
    }

    /// Forces on passive joints at a time, in addition to those of their constant drives, in the
    /// order of [`Articulation::passive_drives`]; `None` if none oscillate.
    pub fn joint_forces(&self, time: f64) -> Option<Vec<f64>> {
        if self.joint_forces.is_empty() {
            return None;
        }
        let force = |joint: usize| -> f64 {
            let of_joint = self.joint_forces.iter().filter(|f| f.sine.joint == joint);
            of_joint.map(|force| force.at(time)).sum()
        };
        Some(
            self.articulation
                .passive_drives()
                .map(|(joint, _)| force(joint))
                .collect(),
        )
    }

    /// Names of joints, joined by ` + `; `constant lengths` without joints.
    pub fn joint_names(&self, joints: &[usize]) -> String {
        let all = self.articulation.joints();
        let names: Vec<&str> = (joints.iter().filter_map(|&joint| all.get(joint)))
            .map(|joint| &joint.name[..])
            .collect();
        match names.is_empty() {
            true => "constant lengths".to_owned(),
            false => names.join(" + "),
        }
    }

    /// [Names of joints](Self::joint_names) for a line of text: of many the first ones and the
    /// number of the others. Labels of different joints may be equal.
    pub fn joint_label(&self, joints: &[usize]) -> String {
        if joints.len() <= MAX_NAMES {
            return self.joint_names(joints);
        }
        let first = self.joint_names(&joints[..FIRST_NAMES]);
        format!("{first} + {} more", joints.len() - FIRST_NAMES)
    }

    /// Gait: the change of the shape in time.
    pub fn gait(&self) -> &Gait {
        &self.gait
    }

    /// Whether a run starts in the periodic state of its gait.
    pub fn starts_periodic(&self) -> bool {
        self.starts_periodic
    }

    /// Options of the flow model.
    pub fn model(&self) -> &ModelOptions {
        &self.model
    }

    /// Options of the finite-element model.
    pub fn fem(&self) -> &FemOptions {
        &self.fem
    }

    /// Options of the search for strokes.
    pub fn optimise(&self) -> &OptimiseOptions {
        &self.optimise
    }

    /// Options of the learning of strokes.
    pub fn learn(&self) -> &LearnOptions {
        &self.learn
    }

    /// Options of the files of a run.
    pub fn output(&self) -> &OutputOptions {
        &self.output
    }

    /// Values in the order of the joints; none for joints without a value.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] for values of other joints, which those of a checked scene are not.
    pub fn joint_values(
        &self,
        key: &str,
        values: &JointValues,
    ) -> Result<Vec<Option<f64>>, SceneError> {
        by_joint(values, self.articulation.joints()).map_err(|problem| SceneError::BadValue {
            place: self.place(key),
            key: key.to_owned(),
            problem,
        })
    }

    /// The prescribed joints whose values differ between two shapes, with the changes.
    ///
    /// Full turns about an axis without advance change no shape, nor do periods of the phase of a
    /// wave or of frames, nor does rounding.
    pub fn shape_changes(&self, from: &[f64], to: &[f64]) -> Vec<(usize, f64)> {
        /// Values that are sines of times close up to rounding.
        const ROUNDING: f64 = 1e-9;
        let period = |joint: usize| {
            let mut periods = self.periodic_coordinates();
            periods.find_map(|(own, period)| (own == joint).then_some(period))
        };
        let joints = self.articulation.joints().iter().enumerate();
        let ends = from.iter().zip(to);
        let changes = joints
            .zip(ends)
            .filter_map(|((number, joint), (from, to))| {
                let closes = matches!(joint.kind, JointKind::Turn { advance: 0.0, .. });
                let turn = closes.then_some(std::f64::consts::TAU);
                let (change, size) = match (joint.kind, turn.or_else(|| period(number))) {
                    (_, Some(turn)) => {
                        let turns = ((to - from) / turn).round();
                        (to - from - turns * turn, to.abs().max(1.0))
                    }
                    (JointKind::Turn { .. }, _) => (to - from, to.abs().max(1.0)),
                    _ if joint.kind.is_signed() => (to - from, to.abs().max(1.0)),
                    _ => (to - from, from.abs().max(to.abs())),
                };
                let is_change = !joint.is_passive() && change.abs() > ROUNDING * size;
                is_change.then_some((number, change))
            });
        changes.collect()
    }

    /// File and line of a key such as `bodies[1].radius`, for messages.
    pub fn place(&self, key: &str) -> String {
        self.document.place(key)
    }

    /// Whether a key, such as `model.tolerance`, is written in the file or set by an override; not
    /// of a key that has its default, or of scenes made by a program.
    pub fn is_written(&self, key: &str) -> bool {
        self.document.is_written(key)
    }

    /// The files that the scene names, surfaces and meshes first, with the hashes of their contents
    /// when the scene was read.
    pub fn source_files(&self) -> Vec<SourceFile> {
        let table = self.gait_table.iter();
        let table = table.map(|table| SourceFile::new(&table.file, table.hash));
        self.sources.iter().cloned().chain(table).collect()
    }

    /// Warnings to be shown to the user: keys with old names, surfaces with lost digits.
    pub fn warnings(&self) -> &[String] {
        self.document.warnings()
    }

    /// Refuses a scene without a gait.
    ///
    /// # Errors
    /// [`SceneError::NotApplicable`].
    pub fn require_gait(&self) -> Result<(), SceneError> {
        if !self.gait.phases.is_empty() {
            return Ok(());
        }
        Err(SceneError::NotApplicable {
            place: self.place("gait"),
            problem: "the scene has no [[gait.phases]] to run; add phases, or use `swim solve` \
                      for one instant"
                .to_owned(),
        })
    }

    /// The initial state of the articulation.
    pub fn initial_state(&self) -> State {
        self.articulation.initial_state()
    }

    /// Number of the first body that is neither a sphere nor a point, or does not stay one.
    pub fn first_nonspherical(&self) -> Option<usize> {
        let deforms = |body: &Body| body.deformation.as_ref().is_some_and(|of| !of.is_sphere());
        let mut bodies = self.bodies.iter();
        bodies.position(|body| !body.shape.is_isotropic() || deforms(body))
    }

    /// Number of the first body that is not a sphere, a spheroid or a point.
    pub fn first_not_spheroidal(&self) -> Option<usize> {
        let is_spheroid = |shape: &Shape| matches!(shape, Shape::Spheroid(_));
        (self.bodies.iter()).position(|b| !b.shape.is_isotropic() && !is_spheroid(&b.shape))
    }

    /// Whether some bodies have inertia.
    pub fn has_masses(&self) -> bool {
        self.bodies.iter().any(|body| body.mass_matrix().is_some())
    }

    /// Whether the flow determines the values of some joints.
    pub fn has_passive_joints(&self) -> bool {
        let joints = self.articulation.joints();
        joints
            .iter()
            .any(|joint| joint.is_passive() || joint.kind.has_attitude())
    }

    /// Whether external forces or torques act on the bodies.
    pub fn has_loads(&self) -> bool {
        let is_loaded = |body: &Body| {
            body.total_force() != Vector3::zeros()
                || body.torque != Vector3::zeros()
                || body.is_driven()
        };
        self.repulsion.is_some() || self.bodies.iter().any(is_loaded)
    }

    /// External force and torque on each body at a time, in the laboratory axes, with weights, the
    /// torque `m × B` of the magnetic field and the repulsion between surfaces.
    ///
    /// `poses` are those of the bodies; their rotations are from the start. Without poses no body
    /// is turned, and nothing is repelled.
    pub fn loads(&self, time: f64, poses: &[Isometry3<f64>]) -> Vec<ExternalLoad> {
        let field = self.field.map(|field| field.at(time));
        let load = |(number, body): (usize, &Body)| {
            let rotation = poses.get(number).map(|pose| pose.rotation);
            let rotation = rotation.unwrap_or_default();
            let mut load = ExternalLoad {
                force: body.total_force(),
                torque: body.torque,
            };
            if let Some(drive) = &body.driving_force {
                load.force += drive.at(time, &rotation);
            }
            if let Some(drive) = &body.driving_torque {
                load.torque += drive.at(time, &rotation);
            }
            if let (Some(field), true) = (field, body.moment != Vector3::zeros()) {
                load.torque += (rotation * body.moment).cross(&field);
            }
            if body.weight != Vector3::zeros() {
                load.torque += body.weight_torque(&rotation);
            }
            load
        };
        let mut loads: Vec<_> = self.bodies.iter().enumerate().map(load).collect();
        if let Some(repulsion) = &self.repulsion {
            repulsion.add_to(&mut loads, &self.bodies, &self.domain, poses);
        }
        loads
    }

    /// The constraints of the joints in a state, with the given velocities of bodies at a time.
    ///
    /// # Errors
    /// Those of [`Articulation::constraints`].
    pub fn constraints(
        &self,
        state: &State,
        shape: &[f64],
        rates: &[f64],
        time: f64,
    ) -> Result<Constraints, RigidError> {
        let set = &self.articulation;
        let joints = set.constraints(state, shape, rates)?;
        with_held_velocities(joints, set, &self.bodies, time)
    }

    /// Whether [`Scene::loads`] depend on the poses of the bodies.
    pub fn has_posed_loads(&self) -> bool {
        self.repulsion.is_some() || self.bodies.iter().any(Body::has_turning_load)
    }

    /// Shortest period of the forces on joints, the loads on bodies, their given velocities and the
    /// magnetic field; `None` if none of them depends on the time.
    pub fn shortest_period(&self) -> Option<f64> {
        self.periods().reduce(f64::min)
    }

    /// Periods of the forces on joints, the loads on bodies, their given velocities and the
    /// magnetic field, of those that depend on the time.
    pub(crate) fn periods(&self) -> impl Iterator<Item = f64> + '_ {
        let of_vector = |vector: &VectorOscillation| {
            (vector.oscillates()).then(|| vector.period / f64::from(vector.order))
        };
        let drives = (self.bodies.iter())
            .flat_map(|body| [&body.driving_force, &body.driving_torque])
            .flatten();
        let given = (self.bodies.iter())
            .flat_map(|body| [&body.velocity, &body.angular_velocity])
            .flatten();
        let of_joints = self.joint_forces.iter();
        of_joints
            .map(|force| force.period / f64::from(force.sine.order))
            .chain(drives.filter_map(move |drive| of_vector(&drive.vector)))
            .chain(given.filter_map(of_vector))
            .chain(self.field.as_ref().and_then(of_vector))
    }

    /// Whether forces on joints, loads on bodies, given velocities or the magnetic field depend on
    /// the time.
    pub fn depends_on_time(&self) -> bool {
        self.shortest_period().is_some()
    }

    /// Whether velocities or angular velocities of bodies are given: of fixed and driven bodies.
    pub fn has_held_bodies(&self) -> bool {
        self.articulation.held_bodies().next().is_some()
    }

    /// Whether the motion depends on the values that the gait prescribes alone.
    ///
    /// This holds for one linkage in unbounded fluid at rest, without loads, held bodies, slip and
    /// passive joints. With slip, the motion also depends on the speed at which the shape changes.
    pub fn is_free(&self) -> bool {
        self.domain == Domain::Unbounded && self.is_driven_by_shape()
    }

    /// Whether the motion depends on the values that the gait prescribes and on the place of the
    /// swimmer alone: as [`Scene::is_free`], in any domain.
    ///
    /// Not if the viscosity depends on the shear rate: then the motion depends on the times of the
    /// gait too.
    pub fn is_driven_by_shape(&self) -> bool {
        !self.has_loads()
            && !self.has_held_bodies()
            && !self.has_surface_velocity()
            && self.articulation.linkages().len() == 1
            && !self.has_passive_joints()
            && !self.has_masses()
            && self.viscosity_law().is_none()
            && self.noise.is_none()
    }

    /// The first key in which another scene has a different flow problem; `None` if it has the
    /// same.
    ///
    /// The flow problem is everything that velocities and forces at given values and rates of the
    /// joints depend on: fluid, domain, bodies and joints. Names, gaits and options may differ.
    ///
    /// ```
    /// use scene::Scene;
    /// let scene = |radius| Scene::builder().ball(radius).sphere("ball", 1.0, [0.0; 3]).build();
    /// assert_eq!(scene(10.0)?.differing_key(&scene(10.0)?), None);
    /// assert_eq!(scene(10.0)?.differing_key(&scene(20.0)?), Some("domain".to_owned()));
    /// # Ok::<(), scene::SceneError>(())
    /// ```
    pub fn differing_key(&self, other: &Self) -> Option<String> {
        let of_scene = [
            ("fluid.viscosity", self.viscosity == other.viscosity),
            ("fluid.law", self.rheology == other.rheology),
            ("fluid.inertia", self.inertia == other.inertia),
            (
                "fluid.density",
                !self.inertia.is_kept() || self.density == other.density,
            ),
            ("background", self.background == other.background),
            ("field", self.field == other.field),
            ("contact", self.repulsion == other.repulsion),
            ("domain", self.domain == other.domain),
            ("bodies", self.bodies.len() == other.bodies.len()),
            ("links", self.joints().eq(other.joints())),
            (
                "gait.arms",
                self.articulation.arms() == other.articulation.arms(),
            ),
        ];
        if let Some((key, _)) = of_scene.into_iter().find(|(_, is_same)| !is_same) {
            return Some(key.to_owned());
        }
        let mut bodies = self.bodies.iter().zip(&other.bodies).enumerate();
        bodies.find_map(|(number, (own, other))| {
            let keys = [
                ("shape", own.shape == other.shape),
                ("position", own.position == other.position),
                ("surface", own.surface == other.surface),
                (
                    "force",
                    own.force == other.force && own.driving_force == other.driving_force,
                ),
                (
                    "torque",
                    own.torque == other.torque && own.driving_torque == other.driving_torque,
                ),
                ("moment", own.moment == other.moment),
                ("density", own.weight == other.weight),
                ("slip", own.slip == other.slip),
                ("deformation", own.deformation == other.deformation),
                ("fixed", own.fixed == other.fixed),
                ("velocity", own.velocity == other.velocity),
                (
                    "angular_velocity",
                    own.angular_velocity == other.angular_velocity,
                ),
                ("mass", own.mass == other.mass),
                ("inertia", own.inertia == other.inertia),
            ];
            let (key, _) = keys.into_iter().find(|(_, is_same)| !is_same)?;
            Some(format!("bodies[{number}].{key}"))
        })
    }

    /// The two bodies of each joint, its kind and what drives it.
    fn joints(&self) -> impl Iterator<Item = (usize, usize, JointKind, JointDrive)> {
        let joints = self.articulation.joints().iter();
        joints.map(|l| (l.body, l.to, l.kind, l.drive))
    }
}
