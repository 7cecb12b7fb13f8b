//! The table of all keys.

use super::flows;
use super::key::KeyDefault::{self, Described, Value};
use super::key::{Key, Kind};
use crate::words::{
    AcceptKind, ArmsKind, DomainKind, EstimatesKind, FormulationKind, GaitKind, GeometryKind,
    InterpolationKind, MeshMotionKind, MirrorKind, ModelKind, ShapeKind, SolverKind,
};

pub(super) const fn key(
    path: &'static str,
    kind: Kind,
    default: KeyDefault,
    meaning: &'static str,
) -> Key {
    Key {
        path,
        kind,
        default,
        meaning,
    }
}

/// All keys of a scene file, in the order in which scenes are written.
pub const KEYS: &[Key] = &[
    flows::GRAVITY,
    key(
        "fluid.viscosity",
        Kind::Positive,
        Value("1"),
        "dynamic viscosity",
    ),
    flows::FLUID_DENSITY,
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
    flows::BACKGROUND_KIND,
    flows::BACKGROUND_VELOCITY,
    flows::BACKGROUND_GRADIENT,
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
    flows::BODY_DENSITY,
    flows::SLIP_B1,
    flows::SLIP_B2,
    flows::SLIP_AXIS,
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
        "gait.phases[].link",
        Kind::Text,
        Described("none: all lengths are constant"),
        "link whose length changes",
    ),
    key(
        "gait.phases[].length",
        Kind::Positive,
        Described("required with `link`"),
        "length of the link at the end of the phase",
    ),
    key(
        "gait.phases[].targets",
        Kind::PositiveByName,
        Described("none; instead of `link` and `length`"),
        "lengths of several links at the end of the phase, by name; they change at the same time",
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
         times and lengths",
    ),
    key(
        "gait.file",
        Kind::Text,
        Described("required for a table"),
        "file of comma-separated values beside the scene file: a line with the names `time` and \
         links, then lines of numbers; the bodies start at the lengths of the first one",
    ),
    key(
        "gait.interpolation",
        Kind::Word(InterpolationKind::WORDS),
        Described("`cubic`, for a table"),
        "between the rows of the table: a spline with two continuous derivatives, periodic if the \
         last row has the lengths of the first one, or constant rates",
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
        "link with the length mean + amplitude sin(2 pi order t / period + phase); several entries \
         for one link are summed",
    ),
    key(
        "gait.harmonics[].mean",
        Kind::Positive,
        Described("that for which the bodies start at their positions"),
        "mean length of the link; the bodies then start at the lengths of `t = 0` along the \
         directions that their positions give",
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
];
