//! The tables of a scene file: every key with its type, its default and its meaning.
//!
//! A key is an `Option` if it has no default, or if being present without need is an error.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::key::{Key, KeyDefault, KeyTable, KeyType, Kind, tables};
use crate::joints::JointWord;
use crate::words::{
    AcceptKind, ArmsKind, AxesKind, BackgroundKind, DeformationWord, DomainKind, DriveKind,
    EnvelopeKind, EstimatesKind, FlowsKind, FormulationKind, GaitKind, GeometryKind, InertiaKind,
    InterpolationKind, LawKind, LearnKind, MeshMotionKind, MesherKind, ModeMotion,
    ModelEstimatesKind, ModelKind, ObjectiveKind, RheologyKind, ShapeKind, SolverKind, StartKind,
    StrokeStart, SurfaceKind, SymmetryKind, TrajectoryKind, WaveKind,
};

tables! {
    /// Keys that stand before the first table.
    pub(crate) struct SceneFile in "" {
        /// Acceleration of gravity, which acts on bodies with a density or a mass.
        #[serde(skip_serializing_if = "is_default")]
        gravity: [f64; 3] | "none",
        /// The fluid.
        fluid: FluidFile,
        /// The region that the fluid fills.
        domain: DomainFile,
        /// The flow in the absence of the bodies.
        background: Option<BackgroundFile>,
        /// The magnetic field.
        field: Option<FieldFile>,
        /// The repulsion between surfaces that nearly touch.
        contact: Option<ContactFile>,
        /// The bodies.
        bodies: Vec<BodyFile>,
        /// The joints.
        #[serde(skip_serializing_if = "is_default")]
        links: Vec<JointFile>,
        /// The copies.
        #[serde(skip_serializing_if = "is_default")]
        copies: Vec<CopiesFile>,
        /// The gait.
        gait: GaitFile,
        /// The model of the flow.
        model: ModelOptions,
        /// The finite elements.
        fem: FemOptions,
        /// The search for strokes.
        optimise: OptimiseOptions,
        /// The learning of strokes.
        learn: LearnOptions,
        /// The files of a run.
        output: OutputOptions,
    }

    /// The fluid: an incompressible liquid, whose viscosity may depend on the shear rate.
    pub(crate) struct FluidFile in "fluid." {
        /// Dynamic viscosity; beside a law its viscosity at rest, or its consistency.
        viscosity: f64 [Positive] = 1.0,
        /// Viscosity as a function of the shear rate. It needs a model by elements.
        law: LawKind,
        /// Viscosity at rest.
        zero_shear_viscosity: Option<f64> [Positive] | "required for carreau, carreau-yasuda, cross",
        /// Viscosity at infinite shear rate.
        infinite_shear_viscosity: Option<f64> [NonNegative] | "0",
        /// One over the shear rate at which the viscosity starts to change.
        relaxation_time: Option<f64> [NonNegative] | "required for carreau, carreau-yasuda, cross",
        /// Power-law index: below 1 the fluid thins, above 1 it thickens.
        index: Option<f64> [Positive] | "required for all laws but newtonian",
        /// Exponent of the law of Carreau and Yasuda; larger values change over fewer rates.
        transition: Option<f64> [Positive] | "2, for carreau-yasuda",
        /// Viscosity of a power law at the shear rate 1.
        consistency: Option<f64> [Positive] | "required for power-law, herschel-bulkley",
        /// Stress below which the fluid does not flow.
        yield_stress: Option<f64> [NonNegative] | "required for herschel-bulkley",
        /// Shear rate `e`, far below those of the flow, that makes power laws regular at rest:
        /// `sqrt(g^2 + e^2)` stands for `g`.
        regularisation: Option<f64> [Positive] | "1e-6, for power-law, herschel-bulkley",
        /// Whether flows follow the law, or results of a Newtonian fluid say what it would change.
        rheology: Option<RheologyKind> | "full",
        /// Density of the fluid, for the buoyancy of bodies with a density, for its inertia, and
        /// for what neglecting inertia costs, which results then have.
        density: Option<f64> [NonNegative] | "0",
        /// Inertia in `swim run`: of the fluid, and of bodies with a density or mass; other bodies
        /// have no mass. It needs `fluid.density` and a container.
        inertia: InertiaKind,
        /// Flow at the start of a run with inertia.
        start: StartKind,
        /// Length of all steps in time of a run with inertia, largest length of those with thermal
        /// noise.
        time_step: Option<f64> [Positive] | "chosen by the error of each step, or by sizes and rates",
        /// Thermal energy `k_B T`, a force times a length: spheres then diffuse by thermal noise
        /// in `swim run`.
        thermal_energy: Option<f64> [NonNegative] | "0",
        /// Seed of the random numbers of the thermal noise.
        seed: Option<u32> [Count] | "1",
    }

    /// The region that the fluid fills, whose walls are at rest. Without this table the fluid is
    /// unbounded; with it, `kind` must be given.
    pub(crate) struct DomainFile in "domain." {
        /// Kind of the region.
        kind: Option<DomainKind>; unbounded,
        /// Radius of the ball or the cylinder.
        radius: Option<f64> [Positive] | "required for ball and cylinder",
        /// Edge lengths of the box, centred at the origin. The box of `periodic` is repeated in all
        /// directions, for spheres by the models oseen, rpy and multipole. Its mean flow is zero or
        /// that of a uniform background, and the mean pressure gradient, which balances the forces
        /// of the bodies, is a result; or the background gives the pressure gradient.
        size: Option<[f64; 3]> [PositiveVector] | "required for box and periodic",
        /// File of the mesh (Gmsh) or of the surface (STL, OBJ, Gmsh), whose coordinates are those
        /// of the scene. A relative path starts at the folder of the scene file.
        file: Option<String> | "required for surface and mesh",
        /// As `surface_kind` of a body.
        surface_kind: Option<SurfaceKind> | "`smooth`, for a surface",
        /// Length of the scene per length of the file.
        scale: Option<f64> [Positive] | "1, for a surface",
        /// Names of the parts of the mesh's boundary that are walls.
        walls: Option<Vec<String>> | "required for mesh",
    }

    /// The flow in the absence of the bodies. In unbounded fluid it is the flow far away, in a
    /// periodic box its mean (`uniform`) or what drives it (`pressure-gradient`); in a container
    /// the walls move with it, except for `poiseuille`, which needs the domain cylinder, whose wall
    /// is at rest.
    pub(crate) struct BackgroundFile in "background." {
        /// Kind of the flow.
        kind: Option<BackgroundKind> | "required in `[background]`",
        /// Velocity. That of `poiseuille` is on the axis of the tube and along it, twice the mean.
        velocity: Option<[f64; 3]> | "required for uniform and poiseuille",
        /// Mean of the gradient of the pressure: the sum of the forces of the bodies on the fluid
        /// over the volume of the box. The flow past bodies that are held, of which there must be
        /// one, is against it.
        pressure_gradient: Option<[f64; 3]> | "required for pressure-gradient",
        /// Rows of the gradient `G` of the velocity `u_i = sum_j G_ij x_j`. Its trace is zero, and
        /// for `extension` it is symmetric.
        gradient: Option<[[f64; 3]; 3]> | "required for shear and extension",
    }

    /// A uniform magnetic field `B`, which acts on bodies with a `moment` m by the torque m × B. It
    /// is mean + amplitude sin(2 pi order t / period + phase) in each component: constant,
    /// oscillating or, with phases that differ by a quarter of a turn, rotating.
    pub(crate) struct FieldFile in "field." {
        /// Mean.
        mean: Option<[f64; 3]> | "[0, 0, 0]",
        /// Amplitudes of the components.
        amplitude: Option<[f64; 3]> | "[0, 0, 0]: a constant field",
        /// Phase angles of the components, in radians. With amplitude = [b, b, 0] and phase =
        /// [1.5707963, 0, 0] the field rotates about z, from x towards y.
        phase: Option<[f64; 3]> | "[0, 0, 0]",
        /// Number of oscillations in a period.
        order: Option<u32> | "1",
        /// Period.
        period: Option<f64> [Positive] | "that of the gait; required with `amplitude` otherwise",
    }

    /// A short-range repulsion between bodies, and between bodies and walls. It is no
    /// hydrodynamics: it stands for roughness or charges, and keeps surfaces apart where
    /// lubrication alone would let them touch in finite time of the integration. In a gap h the
    /// force is strength / (exp(h / range) - 1), along the line of the closest points of the convex
    /// hulls (Brady & Bossis 1985). Without this table there is none.
    pub(crate) struct ContactFile in "contact." {
        /// Length over which the force decays.
        range: Option<f64> [Positive] | "required in `[contact]`",
        /// Force at the gap 0.693 `range`; in narrow gaps it is `strength` times `range` over the
        /// gap.
        strength: Option<f64> [Positive] | "required in `[contact]`",
    }

    /// A body; every body has a `[[bodies]]` of its own. `shape` says which of the lengths are
    /// needed, and other lengths are errors.
    pub(crate) struct BodyFile in "bodies[]." {
        /// Name of the body, unique.
        name: Option<String> | "required",
        /// Shape.
        shape: ShapeKind,
        /// Radius: of a spheroid that of its equator, of a capsule that of its cylinder, of a disk
        /// that to its outer edge, of a torus or a helix that of the middle of the tube about the
        /// axis, of a tube that at its front.
        radius: Option<f64> [Positive]
            | "required unless the shape is ellipsoid, surface, file or point",
        /// Semi-axes of an ellipsoid along x, y and z, before it is turned by `orientation`.
        semi_axes: Option<[f64; 3]> [PositiveVector] | "required for ellipsoid",
        /// Half of the length along the axis of revolution: of a capsule with its round ends, of a
        /// disk half of its thickness.
        half_length: Option<f64> [Positive] | "required for spheroid, capsule and disk",
        /// Length of the centreline of a tube, without its round ends and its head.
        length: Option<f64> [Positive] | "required for tube",
        /// Radius of a tube at its end, to which it tapers smoothly.
        end_radius: Option<f64> [Positive] | "the radius, for a tube",
        /// Radius of a ball in front of a tube, larger than that of the tube.
        head_radius: Option<f64> [Positive] | "no head, for a tube",
        /// Radius of the tube.
        tube_radius: Option<f64> [Positive] | "required for torus and helix",
        /// Length of a helix along its axis per turn: positive if right-handed, negative if
        /// left-handed.
        pitch: Option<f64> | "required for helix",
        /// Number of turns of a helix, at most 1000. Its ends are round.
        turns: Option<f64> [Positive] | "required for helix",
        /// STL, OBJ or Gmsh file of a closed surface, oriented outwards. A relative path starts at
        /// the folder of the scene file.
        file: Option<String> | "required for surface",
        /// How the triangles of the file are understood.
        surface_kind: Option<SurfaceKind> | "`smooth`, for a surface",
        /// Length of the scene per length of the file.
        scale: Option<f64> [Positive] | "1, for a surface",
        /// Point of a surface that is at `position` and about which it turns, in coordinates of the
        /// file.
        centre: Option<[f64; 3]> | "centroid of the volume",
        /// Direction of the axis of a spheroid, capsule, disk or torus in the initial
        /// configuration.
        axis: Option<[f64; 3]>; [1.0, 0.0, 0.0],
        /// Rotation vector in radians that turns a body whose axis is x into its initial
        /// orientation: [0, 0, 1.5707963] makes it y. The body turns with the flow from there.
        orientation: Option<[f64; 3]>; [0.0, 0.0, 0.0],
        /// Centre in the initial configuration.
        position: Option<[f64; 3]> | "required; of `shape = \"file\"` the centroid of its volume",
        /// Name of the body's part of the mesh's boundary.
        surface: Option<String> | "required for `domain.kind = \"mesh\"`",
        /// External force: constant in the laboratory, or a table of mean + amplitude sin(2 pi
        /// order t / period + phase) in each component. Its `phase` is one angle or three, the
        /// period that of the gait by default; with `axes = "body"` the components are along axes
        /// that turn with the body, and are those of the laboratory at the start.
        force: LoadFile,
        /// External torque about the centre: constant, or a table as for `force`.
        torque: Option<LoadFile>; [0.0, 0.0, 0.0],
        /// Magnetic moment in the initial configuration. It turns with the body; `[field]` acts on
        /// it.
        #[serde(skip_serializing_if = "is_default")]
        moment: [f64; 3] | "none",
        /// Whether the body is fixed in space: an obstacle, or a body that holds a swimmer. No
        /// loads act on it but those of its links; the force and the torque that hold it are
        /// results.
        #[serde(skip_serializing_if = "is_default")]
        fixed: bool,
        /// Given velocity of the centre in the laboratory: constant, or a table as for `force`,
        /// without `axes`. The force that drives the body is a result; it rotates freely unless
        /// `angular_velocity` is given too.
        velocity: Option<LoadFile> | "none: the flow determines it",
        /// Given angular velocity in the laboratory: constant, or a table as for `force`, without
        /// `axes`. The torque that drives the body is a result; its centre moves freely unless
        /// `velocity` is given too.
        angular_velocity: Option<LoadFile> | "none: the flow determines it",
        /// Mass; without masses there is no inertia. With gravity its weight is that of the mass
        /// minus that of the displaced fluid. Give mass or density, not both. Of the bodies that
        /// deform, only spheres that change their size may have a mass, and only without gravity.
        mass: f64 [NonNegative] = 0.0,
        /// Moment of inertia about the centre; for zero that of a homogeneous body of the mass. It
        /// grows with the square of the radius of a sphere that changes its size.
        inertia: f64 [NonNegative] = 0.0,
        /// Density. With `gravity` g the force (density - fluid.density) volume g acts on the
        /// centre of volume of the body, in addition to `force`. It has inertia only where the
        /// fluid has (`fluid.inertia`).
        density: Option<f64> [NonNegative] | "that of the fluid: no weight",
        /// Tangential velocity of the surface.
        slip: Option<SlipFile>,
        /// Deformation of the surface.
        deformation: Option<DeformationFile>,
    }

    /// Tangential velocity `-(b1 + b2 n·k) (I - n n^T) k` of the surface of a body, a squirmer,
    /// with the outward normal n and the unit vector k along `axis`.
    pub(crate) struct SlipFile in "bodies[].slip." {
        /// First mode: on a sphere `b1 sin θ`.
        b1: f64 = 0.0,
        /// Second mode: on a sphere `b2 sin θ cos θ`. It is positive for pullers, negative for
        /// pushers.
        b2: f64 = 0.0,
        /// Direction of the axis k in the initial configuration. It turns with the body.
        axis: [f64; 3] = [1.0, 0.0, 0.0],
    }

    /// Deformation of a body, by shape coordinates that the gait changes like the values of joints:
    /// targets = { arm = 8, "BODY.MODE" = 0.1 }. Every sphere has the coordinates BODY.radius and
    /// BODY.volume, of which a scene uses one; a volume that changes at a constant rate has a
    /// constant flux. Modes have the amplitudes BODY.MODE, numbers that are zero at the start
    /// unless the gait gives others; material points of a spheroid are those of the sphere with the
    /// radius of its equator, stretched along its axis. A tube that undulates has the coordinates
    /// BODY.amplitude and BODY.phase, an angle in radians: waves travel from the front to the end
    /// while the phase increases, and stand while the amplitude changes. Frames are shapes of a
    /// surface with the same triangles and have the coordinate BODY.frame: vertices move along
    /// cubic splines through their positions. In a container the sum of the volumes must stay.
    pub(crate) struct DeformationFile in "bodies[].deformation." {
        /// How the surface deforms.
        kind: DeformationWord,
        /// Degree of each mode by its name, from 1 to 12, such as { p2 = 2, p3 = 3 }.
        modes: Option<BTreeMap<String, f64>> | "none",
        /// Order m of modes by their names, from minus to plus the degree n, such as { p2 = 1 }:
        /// their harmonic is c P(cos θ) cos(m φ), or c P(cos θ) sin(-m φ) of negative orders, with
        /// the associated Legendre function P without the sign (-1)^m, c² = 2 (n - m)! / (n + m)!
        /// for the size of m, and the azimuth φ about the axis. Other modes have the order 0.
        orders: Option<BTreeMap<String, f64>> | "0",
        /// How the modes move material points.
        motion: Option<ModeMotion>; radial,
        /// Direction of the axis of the modes in the initial configuration. It turns with the body;
        /// that of a spheroid is its own, whichever of both ends is given.
        axis: Option<[f64; 3]>; [1.0, 0.0, 0.0],
        /// Direction from which azimuths of modes with an order are counted, counterclockwise about
        /// the axis, in the initial configuration; its part along the axis is removed.
        meridian: Option<[f64; 3]>
            | "y for an axis along x, z along y, x along z; required for others",
        /// What the wave changes, for an undulation.
        wave: Option<WaveKind> | "`curvature`, for an undulation",
        /// Envelope of the wave.
        envelope: Option<EnvelopeKind> | "`uniform`, for an undulation",
        /// Number of waves on the length of the tube, from 0.1 to 20.
        waves: Option<f64> [Positive] | "1, for an undulation",
        /// Amplitude at the start: of the angle between the tube and its axis in radians, of
        /// displacements the slope.
        amplitude: Option<f64> | "required for an undulation",
        /// Phase at the start in radians.
        phase: Option<f64> | "0, for an undulation",
        /// Files of the frames after the first one, which is the file of the body. Relative paths
        /// start at the folder of the scene file.
        files: Option<Vec<String>> | "required for frames",
        /// Values of BODY.frame at the frames, increasing; of periodic frames also that at which
        /// the first frame follows the last one.
        at: Option<Vec<f64>> | "0, 1, 2 and so on, for frames",
        /// Whether the first frame follows the last one.
        periodic: Option<bool> | "false, for frames",
        /// Value of BODY.frame at the start.
        frame: Option<f64> | "that of the first frame",
        /// Whether the body is enlarged or reduced about its position, at every value, to the
        /// volume of the first frame.
        keep_volume: Option<bool> | "false, for frames",
    }

    /// A joint between two bodies. The value of a slide is the distance of the centres, that of an
    /// exchange the volume of `body`; that of other joints is the angle in radians from the pose of
    /// the file, counterclockwise about the axis for `body`.
    pub(crate) struct JointFile in "links[]." {
        /// Name of the link, unique.
        name: Option<String> | "required",
        /// Body that the link moves relative to the body `to`.
        body: Option<String> | "required",
        /// Body that it is linked to.
        to: Option<String> | "required",
        /// Relative motion of the two bodies.
        joint: JointWord,
        /// Direction of the axis in the pose of the file.
        axis: Option<[f64; 3]>
            | "required for hinges; from `to` to `body` for rotors and screws",
        /// Point of the axis, or centre of a ball, in the pose of the file.
        pivot: Option<[f64; 3]>
            | "centre of `to` for hinges and balls, of `body` for rotors and screws",
        /// Translation along the axis per turn.
        pitch: Option<f64> | "required for screws",
        /// What determines the value of the joint. Balls are always free.
        drive: Option<DriveKind>; prescribed,
        /// Force of the spring per change of the value; torque per radian for joints that turn.
        stiffness: Option<f64> [NonNegative] | "required for springs",
        /// Value at which the spring has no force.
        rest: Option<f64> | "the value at the start",
        /// Force that increases the value, torque for joints that turn: a constant, or mean +
        /// amplitude sin(2 pi order t / period + phase), with the gait's period by default.
        force: Option<ForceFile> | "required for the drive `force`",
        /// Force against the motion of the joint, per rate of its value.
        damping: Option<f64> [NonNegative] | "0, if not prescribed",
    }

    /// Copies of a body with all bodies that links connect to it, at given or random places. The
    /// copies of `left` are `left-2`, `left-3` and so on, those of links alike; they follow the
    /// gait of their originals. Forces and torques keep their directions, axes turn.
    pub(crate) struct CopiesFile in "copies[]." {
        /// Name of the body whose place is given.
        of: Option<String> | "required",
        /// Positions of the copies of this body.
        positions: Option<Vec<[f64; 3]>> | "random in a box",
        /// Rotations of the copies about this body, as rotation vectors in radians.
        orientations: Option<Vec<[f64; 3]>> | "none; with `positions`",
        /// Number of copies at random places.
        count: Option<u32> | "required without `positions`",
        /// Edges of the box of random positions.
        size: Option<[f64; 3]> [PositiveVector] | "required without `positions`",
        /// Centre of the box.
        centre: [f64; 3] = [0.0, 0.0, 0.0],
        /// Whether random copies are turned at random, all rotations being alike.
        isotropic: bool,
        /// Smallest gap of random copies to all spheres before them.
        gap: f64 [NonNegative] = 0.0,
        /// Seed of the random numbers.
        seed: u32 = 1,
    }

    /// The values of the joints in time: phases, smooth oscillations or a table in a file. They are
    /// repeated `cycles` times.
    pub(crate) struct GaitFile in "gait." {
        /// How bodies are attached to arms that rotate.
        arms: ArmsKind,
        /// Number of times that the phases are repeated.
        cycles: u32 = 1,
        /// Whether the run starts in the periodic state, which is searched for first: of the values
        /// of passive joints and the velocities of bodies with mass, and of a fluid with inertia
        /// after as many cycles as it needs. Otherwise it starts from the pose of the file.
        periodic: bool,
        /// The phases of one cycle, of which there must be one.
        phases: Option<Vec<PhaseFile>>,
        /// How the gait is given.
        kind: Option<GaitKind> | "what is given",
        /// File of comma-separated values next to the scene file: a line with the names `time` and
        /// links, then lines of numbers. The bodies start at the values of the first one.
        file: Option<String> | "required for a table",
        /// Interpolation between the rows of the table.
        interpolation: Option<InterpolationKind> | "`cubic`, for a table",
        /// Period of the oscillations, one cycle.
        period: Option<f64> [Positive] | "required with `harmonics`",
        /// The terms of the oscillations, of which there must be one.
        harmonics: Option<Vec<HarmonicFile>>,
    }

    /// A phase of the gait, in which joints change their values at constant rates. Phases follow
    /// one another in the order of the file.
    pub(crate) struct PhaseFile in "gait.phases[]." {
        /// Link whose value changes.
        link: Option<String> | "none: all joints are at rest",
        /// Value of the link at the end of the phase: length of a slide, angle of other joints,
        /// volume of an exchange, or a shape coordinate of a body such as "BODY.radius".
        length: Option<f64> | "required with `link`",
        /// Values of several links at the end of the phase, by name. They change at the same time.
        targets: Option<BTreeMap<String, f64>> | "none; instead of `link` and `length`",
        /// Duration of the phase.
        duration: f64 [Positive] = 1.0,
    }

    /// A term of a smooth gait: the link has the value mean + amplitude sin(2 pi order t / period +
    /// phase). Several terms of one link are summed.
    pub(crate) struct HarmonicFile in "gait.harmonics[]." {
        /// Link whose value oscillates.
        link: Option<String> | "required",
        /// Mean value of the link. The bodies then start at the values of `t = 0`.
        mean: Option<f64> | "that for which the bodies start at their positions",
        /// Amplitude of the term.
        amplitude: Option<f64> [Positive] | "required without `turn`",
        /// Change of the value in a period in proportion to time, instead of an oscillation: the
        /// phase of a wave turns by whole turns of 2π.
        turn: Option<f64> | "0",
        /// Phase angle of the term, in radians.
        phase: f64 [NonNegative] = 0.0,
        /// Number of oscillations in a period.
        order: u32 = 1,
    }

    /// Options of the model of the flow.
    pub struct ModelOptions: Copy in "model." {
        /// Model of the flow.
        kind: ModelKind,
        /// Tolerated relative error of the net displacement per cycle. Of `oseen`, `rpy` and `fem`
        /// it is the error of the integration only; `fem.target` is for the mesh.
        // Figures and comparisons with published strokes need three digits.
        tolerance: f64 [Positive] = 1e-3,
        /// Factor on the tolerance of single solutions and steps, for runs whose error bar would
        /// miss the tolerance because the net displacement is smaller than predicted.
        tolerance_factor: Option<f64> [Positive] | "1, or smaller where a run finds that it needs it",
        /// What a run does with a result whose error bar is larger than the tolerance.
        accept: AcceptKind,
        /// How the errors of `oseen`, `rpy` and `multipole` are estimated.
        estimates: ModelEstimatesKind,
    }

    /// Options of the finite-element model.
    pub struct FemOptions: Copy in "fem." {
        /// Method by which the constraints of the links are imposed.
        formulation: FormulationKind,
        /// Solver of the linear systems.
        solver: SolverKind,
        /// Number of subdomains of `solver = "schwarz"`.
        subdomains: u32 = 8,
        /// Layers of overlap of `solver = "schwarz"`.
        overlap: u32 = 1,
        /// True residual at which the solver stops, relative to the right-hand side.
        rtol: f64 [Positive] = 1e-8,
        /// Element size on the surfaces of the bodies.
        surface_size: Option<f64> [Positive] | "0.4 of the radius",
        /// Factor on the element sizes on all bodies.
        size_factor: Option<f64> [Positive] | "1, or what `fem.target` needs",
        /// Target of the relative discretisation error: of velocities and forces for one
        /// configuration, of the net displacement for a gait. It determines the element sizes,
        /// unless `size_factor` is given.
        target: Option<f64> [Positive] | "none: the mesh is not adapted",
        /// Whether discretisation errors are estimated. Without estimates a stroke takes about two
        /// thirds of the time.
        estimates: EstimatesKind,
        /// Shape of the elements at the surfaces of the bodies.
        geometry: GeometryKind,
        /// Method by which the mesh moves with the bodies until it is remeshed.
        mesh_motion: MeshMotionKind,
        /// Program that meshes the fluid again inside the walls of a mesh file.
        mesher: MesherKind,
        /// Whether symmetry planes are used: the coordinate planes through the origin about which
        /// bodies, loads, slip, background flow and domain are symmetric for the whole run. One
        /// side of each is meshed, with a half or a quarter of the degrees of freedom; output shows
        /// the whole fluid.
        symmetry: SymmetryKind,
        /// Flows that a run writes for ParaView.
        flows: FlowsKind,
    }

    /// Options of `swim map`, `swim optimise` and `swim sizes`.
    pub struct OptimiseOptions in "optimise." {
        /// What is optimised.
        objective: ObjectiveKind,
        /// Where the stroke starts.
        start: StrokeStart,
        /// Net displacement of the stroke.
        displacement: Option<f64> [Positive] | "that of the gait; for `objective = \"energy\"`",
        /// Net rotation of the stroke about `axis`, in radians.
        rotation: Option<f64> | "required for `objective = \"rotation\"`",
        /// Direction in which the displacement counts, in the frame of the start.
        direction: Option<[f64; 3]> | "none: the length of the displacement counts",
        /// Axis of the rotation for `objective = "rotation"`.
        axis: [f64; 3] = [0.0, 0.0, 1.0],
        /// Smallest values of the joints, for `swim map` and `swim optimise`.
        lower: Option<JointValues> | "the smallest values in the gait",
        /// Largest values of the joints.
        upper: Option<JointValues> | "the largest values in the gait",
        /// Smallest gap between bodies that a slide connects. It raises `lower`.
        gap: Option<f64> [NonNegative] | "a tenth of the smallest radius",
        /// Smallest and largest radius that `swim sizes` may choose. The sum of the volumes stays.
        radii: Option<[f64; 2]> | "none: the radii stay",
        /// Smallest and largest length along the gait of the arms that `swim sizes` may lengthen or
        /// shorten. The sum of the lengths stays.
        arms: Option<[f64; 2]> | "none: the lengths stay",
        /// Smallest and largest number of waves on a tube that undulates, for `swim optimise`; with
        /// `lower` and `upper` of its amplitude both vary.
        waves: Option<[f64; 2]> | "none: the number of waves stays",
        /// Period of the stroke.
        period: f64 [Positive] = 1.0,
        /// Mean power of the stroke, which determines its period.
        power: Option<f64> [Positive] | "none: the period is given",
        /// Largest rates of the joints: the stroke is as fast as they and `max_power` allow.
        max_rate: Option<JointValues> | "none",
        /// Largest power on the fluid along the stroke, instead of `power` and `period`.
        max_power: Option<f64> [Positive] | "none",
        /// Largest number of terms of the series of each joint, at most 128. Strokes of
        /// `objective = "speed"` have at most twice as many corners.
        // Strokes that touch their limits gain a factor of four to eight by doubling the number of
        // terms, and need this number for four digits.
        terms: u32 = 64,
        /// Relative change of the optimum, with twice as many terms, at which the search ends.
        // The error that is left is a fraction of the last change: four digits.
        tolerance: f64 [Positive] = 2e-4,
    }

    /// Options of `swim learn`.
    pub struct LearnOptions in "learn." {
        /// The method.
        method: LearnKind,
        /// Values of contracted joints.
        contracted: Option<JointValues> | "required for `swim learn`",
        /// Values of extended joints.
        extended: Option<JointValues> | "the values at the start",
        /// Direction in which the displacement of the mean of the bodies is rewarded.
        direction: [f64; 3] = [1.0, 0.0, 0.0],
        /// Number of episodes. Each starts with all joints extended.
        episodes: u32 = 100,
        /// Number of steps of an episode. A step contracts or extends one joint.
        steps: u32 = 100,
        /// Discount of rewards per step, below 1. Short-sighted swimmers do not learn to swim.
        // Far above 0.2748, below which three spheres do not learn to swim.
        discount: f64 [NonNegative] = 0.9,
        /// Share of an old value that an update replaces, at most 1.
        // Rewards are not random, so that large updates converge.
        rate: f64 [Positive] = 0.5,
        /// Probability of a random step, at most 1.
        // Frequent random steps: every state must be visited often.
        exploration: f64 [NonNegative] = 0.3,
        /// Seed of the random numbers.
        seed: u32 = 1,
    }

    /// Files that `swim run` writes.
    pub struct OutputOptions in "output." {
        /// Number of equal intervals of time, from the start to the end of the gait, at whose ends
        /// the trajectory has rows, all with velocities, forces and torques.
        samples: Option<u32> | "a row for each solve and each end of a phase",
        /// File of the trajectory.
        trajectory: TrajectoryKind,
    }
}

/// Default of `bodies[].axis`, which only bodies of revolution have.
pub(crate) const DEFAULT_AXIS: [f64; 3] = [1.0, 0.0, 0.0];

/// Default of `bodies[].orientation`, which spheres and points do not have.
pub(crate) const DEFAULT_ORIENTATION: [f64; 3] = [0.0; 3];

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Values of joints: one for all joints, one per joint, or some by the names of the joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum JointValues {
    /// The same value for all joints that the gait can prescribe.
    All(f64),
    /// One value per joint, in the order of the file.
    List(Vec<f64>),
    /// Values by the names of joints; other joints have none.
    Named(BTreeMap<String, f64>),
}

impl KeyType for JointValues {
    const KIND: Kind = Kind::JointValues;
}

/// Value of `links[].force`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum ForceFile {
    Constant(f64),
    Harmonic(HarmonicForceFile),
}

impl KeyType for ForceFile {
    const KIND: Kind = Kind::Oscillation;
}

/// Value of `bodies[].force` and `bodies[].torque`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum LoadFile {
    Constant([f64; 3]),
    Driving(DriveFile),
}

impl KeyType for LoadFile {
    const KIND: Kind = Kind::Load;
    const DEFAULT: &'static str = "[0.0, 0.0, 0.0]";
}

impl Default for LoadFile {
    fn default() -> Self {
        Self::Constant([0.0; 3])
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct DriveFile {
    pub mean: [f64; 3],
    pub amplitude: [f64; 3],
    pub phase: PhaseAngles,
    pub order: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
    pub axes: AxesKind,
}

impl Default for DriveFile {
    fn default() -> Self {
        Self {
            mean: [0.0; 3],
            amplitude: [0.0; 3],
            phase: PhaseAngles::All(0.0),
            order: 1,
            period: None,
            axes: AxesKind::default(),
        }
    }
}

/// Phase angles of three components.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub(crate) enum PhaseAngles {
    All(f64),
    Each([f64; 3]),
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct HarmonicForceFile {
    pub mean: f64,
    pub amplitude: Option<f64>,
    pub phase: f64,
    pub order: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
}

impl Default for HarmonicForceFile {
    fn default() -> Self {
        Self {
            mean: 0.0,
            amplitude: None,
            phase: 0.0,
            order: 1,
            period: None,
        }
    }
}
