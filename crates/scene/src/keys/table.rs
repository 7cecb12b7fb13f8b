//! The table of all keys.

use super::key::KeyDefault::{self, Described, Value};
use super::key::{Key, Kind};
use super::of_bodies::OF_BODIES;
use crate::words::{
    AcceptKind, ArmsKind, DomainKind, EstimatesKind, FormulationKind, GaitKind, GeometryKind,
    InterpolationKind, MeshMotionKind, MirrorKind, ModelKind, SolverKind, SurfaceKind,
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
pub const KEYS: &[Key] = &all();

/// The keys of all groups in one array.
const fn all() -> [Key; OF_FLUID.len() + OF_BODIES.len() + OTHERS.len()] {
    let mut keys = [OF_FLUID[0]; OF_FLUID.len() + OF_BODIES.len() + OTHERS.len()];
    let mut k = 0;
    while k < keys.len() {
        keys[k] = if k < OF_FLUID.len() {
            OF_FLUID[k]
        } else if k < OF_FLUID.len() + OF_BODIES.len() {
            OF_BODIES[k - OF_FLUID.len()]
        } else {
            OTHERS[k - OF_FLUID.len() - OF_BODIES.len()]
        };
        k += 1;
    }
    keys
}

/// Keys of the groups `fluid` and `domain`.
const OF_FLUID: &[Key] = &[
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
         cylinder about the x axis, the half-space above the wall `z = 0`, the inside of a closed \
         surface, or the volume of a mesh file",
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
        Described("required for surface and mesh"),
        "file of the mesh (Gmsh) or of the surface (STL, OBJ, Gmsh), whose coordinates are those \
         of the scene; a relative path starts at the folder of the scene file",
    ),
    key(
        "domain.surface_kind",
        Kind::Word(SurfaceKind::WORDS),
        Described("`smooth`, for a surface"),
        "as `bodies[].surface_kind`",
    ),
    key(
        "domain.scale",
        Kind::Positive,
        Described("1, for a surface"),
        "length of the scene per length of the file",
    ),
    key(
        "domain.walls",
        Kind::Texts,
        Described("required for mesh"),
        "names of the parts of the mesh's boundary that are walls",
    ),
];

/// Keys of the groups `links`, `gait`, `model` and `fem`.
const OTHERS: &[Key] = &[
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
