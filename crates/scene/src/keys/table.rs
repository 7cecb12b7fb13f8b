//! The table of all keys.

use super::key::KeyDefault::{self, Described, Value};
use super::key::{Key, Kind};
use crate::design_words::{LearnKind, ObjectiveKind, StrokeStart};
use crate::words::{
    AcceptKind, ArmsKind, DomainKind, DriveKind, EstimatesKind, FormulationKind, GaitKind,
    GeometryKind, InterpolationKind, JointKind, MeshMotionKind, MirrorKind, ModelKind, ShapeKind,
    SolverKind,
};

const fn key(path: &'static str, kind: Kind, default: KeyDefault, meaning: &'static str) -> Key {
    Key {
        path,
        kind,
        default,
        meaning,
    }
}

/// All keys of a scene file, in the order in which scenes are written.
pub const KEYS: &[Key] = &[
    key(
        "fluid.viscosity",
        Kind::Positive,
        Value("1"),
        "dynamic viscosity",
    ),
    key(
        "domain.kind",
        Kind::Word(DomainKind::WORDS),
        Value("unbounded"),
        "region that the fluid fills: the whole space, a ball or a box about the origin, a \
         cylinder about the x axis, the half-space above the wall `z = 0`, or the volume of a \
         mesh file",
    ),
    key(
        "domain.radius",
        Kind::Positive,
        Described("required for ball and cylinder"),
        "radius of the ball or the cylinder",
    ),
    key(
        "domain.size",
        Kind::PositiveVector,
        Described("required for box"),
        "edge lengths of the box",
    ),
    key(
        "domain.file",
        Kind::Text,
        Described("required for mesh"),
        "Gmsh file; a relative path starts at the folder of the scene file",
    ),
    key(
        "domain.walls",
        Kind::Texts,
        Described("required for mesh"),
        "names of the parts of the mesh's boundary that are walls",
    ),
    key(
        "bodies[].name",
        Kind::Text,
        Described("required"),
        "name of the body, unique",
    ),
    key(
        "bodies[].shape",
        Kind::Word(ShapeKind::WORDS),
        Value("sphere"),
        "shape; a point is a massless joint without a surface",
    ),
    key(
        "bodies[].radius",
        Kind::Positive,
        Described("required unless the shape is ellipsoid or point"),
        "radius; of a spheroid: of its equator; of a capsule: of its cylinder; of a disk: to its \
         outer edge; of a torus or a helix: of the middle of the tube about the axis",
    ),
    key(
        "bodies[].semi_axes",
        Kind::PositiveVector,
        Described("required for ellipsoid"),
        "semi-axes of an ellipsoid along x, y and z, before it is turned by `orientation`",
    ),
    key(
        "bodies[].half_length",
        Kind::Positive,
        Described("required for spheroid, capsule and disk"),
        "half of the length along the axis of revolution: of a capsule with its round ends, of a \
         disk half of its thickness",
    ),
    key(
        "bodies[].tube_radius",
        Kind::Positive,
        Described("required for torus and helix"),
        "radius of the tube",
    ),
    key(
        "bodies[].pitch",
        Kind::Number,
        Described("required for helix"),
        "length of a helix along its axis per turn: positive if right-handed, negative if \
         left-handed",
    ),
    key(
        "bodies[].turns",
        Kind::Positive,
        Described("required for helix"),
        "number of turns of a helix, at most 1000; its ends are round",
    ),
    key(
        "bodies[].axis",
        Kind::Vector,
        Value("[1, 0, 0]"),
        "direction of the axis of a spheroid, capsule, disk or torus in the initial configuration",
    ),
    key(
        "bodies[].orientation",
        Kind::Vector,
        Value("[0, 0, 0]"),
        "rotation vector in radians that turns a body whose axis is x into its initial \
         orientation: [0, 0, 1.5707963] makes it y; the body turns with the flow from there",
    ),
    key(
        "bodies[].position",
        Kind::Vector,
        Described("required"),
        "centre in the initial configuration",
    ),
    key(
        "bodies[].surface",
        Kind::Text,
        Described("required for `domain.kind = \"mesh\"`"),
        "name of the body's part of the mesh's boundary",
    ),
    key(
        "bodies[].force",
        Kind::Vector,
        Value("[0, 0, 0]"),
        "external force",
    ),
    key(
        "bodies[].torque",
        Kind::Vector,
        Value("[0, 0, 0]"),
        "external torque about the centre",
    ),
    key(
        "bodies[].fixed",
        Kind::Flag,
        Value("false"),
        "whether the body is an obstacle at rest, which has no links and no loads",
    ),
    key(
        "bodies[].mass",
        Kind::NonNegative,
        Value("0"),
        "mass, for time stepping with inertia from a program; `swim` needs zero: no inertia",
    ),
    key(
        "bodies[].inertia",
        Kind::NonNegative,
        Value("0"),
        "moment of inertia about the centre, for time stepping with inertia from a program; \
         `swim` needs zero: no inertia",
    ),
    key(
        "links[].name",
        Kind::Text,
        Described("required"),
        "name of the link, unique",
    ),
    key(
        "links[].body",
        Kind::Text,
        Described("required"),
        "body that the link moves relative to the body `to`",
    ),
    key(
        "links[].to",
        Kind::Text,
        Described("required"),
        "body that it is linked to",
    ),
    key(
        "links[].joint",
        Kind::Word(JointKind::WORDS),
        Value("slide"),
        "relative motion of the two bodies: along the line of their centres (slide), about an axis \
         (hinge, rotor), about a point (ball), about and along an axis (screw), or none (fixed); \
         the value of a slide is the distance of the centres, that of the others the angle in \
         radians from the pose of the file, counterclockwise about the axis for `body`",
    ),
    key(
        "links[].axis",
        Kind::Vector,
        Described("required for hinges; from `to` to `body` for rotors and screws"),
        "direction of the axis in the pose of the file",
    ),
    key(
        "links[].pivot",
        Kind::Vector,
        Described("centre of `to` for hinges and balls, of `body` for rotors and screws"),
        "point of the axis, or centre of a ball, in the pose of the file",
    ),
    key(
        "links[].pitch",
        Kind::Number,
        Described("required for screws"),
        "translation along the axis per turn",
    ),
    key(
        "links[].drive",
        Kind::Word(DriveKind::WORDS),
        Value("prescribed"),
        "what determines the value of the joint: the gait (prescribed), a spring, a constant force \
         or nothing (free); balls are always free",
    ),
    key(
        "links[].stiffness",
        Kind::NonNegative,
        Described("required for springs"),
        "force of the spring per change of the value; torque per radian for joints that turn",
    ),
    key(
        "links[].rest",
        Kind::Number,
        Described("the value at the start"),
        "value at which the spring has no force",
    ),
    key(
        "links[].force",
        Kind::Number,
        Described("required for the drive `force`"),
        "force that increases the value; torque for joints that turn",
    ),
    key(
        "links[].damping",
        Kind::NonNegative,
        Described("0, if not prescribed"),
        "force against the motion of the joint, per rate of its value",
    ),
    key(
        "gait.arms",
        Kind::Word(ArmsKind::WORDS),
        Value("clamped"),
        "bodies keep their orientation relative to the frame (clamped), rotate freely on it \
         (free), or arms keep their direction in the laboratory frame (lab)",
    ),
    key(
        "gait.cycles",
        Kind::Count,
        Value("1"),
        "number of times that the phases are repeated",
    ),
    key(
        "gait.periodic",
        Kind::Flag,
        Value("false"),
        "whether passive joints start from the values of the periodic state, which are searched \
         first; otherwise they start from the pose of the file",
    ),
    key(
        "gait.phases[].link",
        Kind::Text,
        Described("none: all joints are at rest"),
        "link whose value changes",
    ),
    key(
        "gait.phases[].length",
        Kind::Number,
        Described("required with `link`"),
        "value of the link at the end of the phase: length of a slide, angle of other joints",
    ),
    key(
        "gait.phases[].targets",
        Kind::NumbersByName,
        Described("none; instead of `link` and `length`"),
        "values of several links at the end of the phase, by name; they change at the same time",
    ),
    key(
        "gait.phases[].duration",
        Kind::Positive,
        Value("1"),
        "duration of the phase",
    ),
    key(
        "gait.kind",
        Kind::Word(GaitKind::WORDS),
        Described("what is given"),
        "phases with constant rates, smooth oscillations of several links at once, or a table of \
         times and values",
    ),
    key(
        "gait.file",
        Kind::Text,
        Described("required for a table"),
        "file of comma-separated values beside the scene file: a line with the names `time` and \
         links, then lines of numbers; the bodies start at the values of the first one",
    ),
    key(
        "gait.interpolation",
        Kind::Word(InterpolationKind::WORDS),
        Described("`cubic`, for a table"),
        "between the rows of the table: a spline with two continuous derivatives, periodic if the \
         last row has the values of the first one, the same with a corner there, or constant rates",
    ),
    key(
        "gait.period",
        Kind::Positive,
        Described("required with `harmonics`"),
        "period of the oscillations, one cycle",
    ),
    key(
        "gait.harmonics[].link",
        Kind::Text,
        Described("required"),
        "link with the value mean + amplitude sin(2 pi order t / period + phase); several entries \
         for one link are summed",
    ),
    key(
        "gait.harmonics[].mean",
        Kind::Number,
        Described("that for which the bodies start at their positions"),
        "mean value of the link; the bodies then start at the values of `t = 0`",
    ),
    key(
        "gait.harmonics[].amplitude",
        Kind::Positive,
        Described("required"),
        "amplitude of the term",
    ),
    key(
        "gait.harmonics[].phase",
        Kind::NonNegative,
        Value("0"),
        "phase angle of the term, in radians",
    ),
    key(
        "gait.harmonics[].order",
        Kind::Count,
        Value("1"),
        "number of oscillations in a period",
    ),
    key(
        "model.kind",
        Kind::Word(ModelKind::WORDS),
        Value("auto"),
        "model of the flow; `auto` takes the cheapest model that meets the tolerance",
    ),
    key(
        "model.tolerance",
        Kind::Positive,
        Value("1e-3"),
        "tolerated relative error of the net displacement per cycle; of `oseen`, `rpy` and `fem` \
         the error of the integration only, see `fem.target` for the mesh",
    ),
    key(
        "model.accept",
        Kind::Word(AcceptKind::WORDS),
        Value("tolerance"),
        "`tolerance`: a run whose error bar exceeds the tolerance ends with exit code 3 and what \
         was reached; `best`: it ends with a warning",
    ),
    key(
        "fem.formulation",
        Kind::Word(FormulationKind::WORDS),
        Value("p-tilde"),
        "how the constraints of the links are imposed",
    ),
    key(
        "fem.solver",
        Kind::Word(SolverKind::WORDS),
        Value("block"),
        "solver of the linear systems; `minres` needs the least memory and a symmetric \
         formulation, `schwarz` is for comparison",
    ),
    key(
        "fem.subdomains",
        Kind::Count,
        Value("8"),
        "number of subdomains of `solver = \"schwarz\"`",
    ),
    key(
        "fem.overlap",
        Kind::Count,
        Value("1"),
        "layers of overlap of `solver = \"schwarz\"`",
    ),
    key(
        "fem.rtol",
        Kind::Positive,
        Value("1e-8"),
        "true residual at which the solver stops, relative to the right-hand side",
    ),
    key(
        "fem.surface_size",
        Kind::Positive,
        Described("0.4 of the radius"),
        "element size on the surfaces of the bodies",
    ),
    key(
        "fem.size_factor",
        Kind::Positive,
        Described("1, or what `fem.target` needs"),
        "factor on the element sizes on all bodies",
    ),
    key(
        "fem.target",
        Kind::Positive,
        Described("none: the mesh is not adapted"),
        "target of the relative discretisation error: of velocities and forces for one \
         configuration, of the net displacement for a gait; determines the element sizes, \
         unless `size_factor` is given",
    ),
    key(
        "fem.estimates",
        Kind::Word(EstimatesKind::WORDS),
        Value("on"),
        "whether discretisation errors are estimated; without estimates a stroke takes about \
         two thirds of the time",
    ),
    key(
        "fem.geometry",
        Kind::Word(GeometryKind::WORDS),
        Value("curved"),
        "shape of the elements at the surfaces of the bodies",
    ),
    key(
        "fem.mesh_motion",
        Kind::Word(MeshMotionKind::WORDS),
        Value("auto"),
        "how the mesh moves with the bodies until it is remeshed; `auto` is \
         `kanchi-masud`, and for the mesh of a file `biharmonic` and other methods before the file \
         is refused; the rest is for comparison",
    ),
    key(
        "fem.mirror",
        Kind::Word(MirrorKind::WORDS),
        Value("auto"),
        "`auto` finds the coordinate planes through the origin about which bodies, loads and \
         domain are symmetric for the whole run, and meshes one side of each: a half or a \
         quarter of the degrees of freedom; output shows the whole fluid",
    ),
    key(
        "optimise.objective",
        Kind::Word(ObjectiveKind::WORDS),
        Value("efficiency"),
        "what `swim optimise` searches: the stroke of the highest Lighthill efficiency, of the \
         largest displacement, or of the least energy for a displacement or a rotation",
    ),
    key(
        "optimise.start",
        Kind::Word(StrokeStart::WORDS),
        Value("closed"),
        "a smooth closed stroke, or one that starts at the shape of the scene, where it may have a \
         corner (fixed)",
    ),
    key(
        "optimise.displacement",
        Kind::Positive,
        Described("that of the gait; for `objective = \"energy\"`"),
        "net displacement of the stroke",
    ),
    key(
        "optimise.rotation",
        Kind::Number,
        Described("required for `objective = \"rotation\"`"),
        "net rotation of the stroke about `axis`, in radians",
    ),
    key(
        "optimise.direction",
        Kind::Vector,
        Described("none: the length of the displacement counts"),
        "direction in which the displacement counts, in the frame of the start",
    ),
    key(
        "optimise.axis",
        Kind::Vector,
        Value("[0, 0, 1]"),
        "axis of the rotation that `objective = \"rotation\"` asks for",
    ),
    key(
        "optimise.lower",
        Kind::JointValues,
        Described("the smallest values in the gait"),
        "smallest values of the joints, for `swim map` and `swim optimise`",
    ),
    key(
        "optimise.upper",
        Kind::JointValues,
        Described("the largest values in the gait"),
        "largest values of the joints",
    ),
    key(
        "optimise.gap",
        Kind::NonNegative,
        Described("a tenth of the smallest radius"),
        "smallest gap between bodies that a slide connects; it raises `lower`",
    ),
    key(
        "optimise.period",
        Kind::Positive,
        Value("1"),
        "period of the stroke",
    ),
    key(
        "optimise.power",
        Kind::Positive,
        Described("none: the period is given"),
        "mean power of the stroke, which determines its period",
    ),
    key(
        "optimise.terms",
        Kind::Count,
        Value("64"),
        "largest number of terms of the series of each joint, at most 128",
    ),
    key(
        "optimise.tolerance",
        Kind::Positive,
        Value("2e-4"),
        "relative change of the optimum, with twice as many terms, at which the search ends",
    ),
    key(
        "learn.method",
        Kind::Word(LearnKind::WORDS),
        Value("q"),
        "Q-learning, or double Q-learning",
    ),
    key(
        "learn.contracted",
        Kind::JointValues,
        Described("required for `swim learn`"),
        "values of contracted joints",
    ),
    key(
        "learn.extended",
        Kind::JointValues,
        Described("the values at the start"),
        "values of extended joints",
    ),
    key(
        "learn.direction",
        Kind::Vector,
        Value("[1, 0, 0]"),
        "direction in which the displacement of the mean of the bodies is rewarded",
    ),
    key(
        "learn.episodes",
        Kind::Count,
        Value("100"),
        "number of episodes; each starts with all joints extended",
    ),
    key(
        "learn.steps",
        Kind::Count,
        Value("100"),
        "number of steps of an episode; a step contracts or extends one joint",
    ),
    key(
        "learn.discount",
        Kind::NonNegative,
        Value("0.9"),
        "discount of rewards per step, below 1; short-sighted swimmers do not learn to swim",
    ),
    key(
        "learn.rate",
        Kind::Positive,
        Value("0.5"),
        "share of an old value that an update replaces, at most 1",
    ),
    key(
        "learn.exploration",
        Kind::NonNegative,
        Value("0.3"),
        "probability of a random step, at most 1",
    ),
    key(
        "learn.seed",
        Kind::Count,
        Value("1"),
        "seed of the random numbers",
    ),
];
