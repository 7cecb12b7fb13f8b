//! The table of all keys.

use super::key::KeyDefault::{self, Described, Value};
use super::key::{Key, Kind};
use super::of_bodies::OF_BODIES;
use super::of_design::OF_DESIGN;
use super::of_gait::OF_GAIT;
use crate::output_words::FlowsKind;
use crate::words::{
    AcceptKind, BackgroundKind, DomainKind, EstimatesKind, FormulationKind, GeometryKind,
    MeshMotionKind, MesherKind, ModelKind, SolverKind, SurfaceKind, SymmetryKind,
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

/// The groups, in order.
const GROUPS: [&[Key]; 5] = [OF_FLUID, OF_BODIES, OF_GAIT, OTHERS, OF_DESIGN];

const COUNT: usize =
    OF_FLUID.len() + OF_BODIES.len() + OF_GAIT.len() + OF_DESIGN.len() + OTHERS.len();

/// The keys of all groups in one array.
const fn all() -> [Key; COUNT] {
    let mut keys = [OF_FLUID[0]; COUNT];
    let (mut k, mut group) = (0, 0);
    while group < GROUPS.len() {
        let mut number = 0;
        while number < GROUPS[group].len() {
            keys[k] = GROUPS[group][number];
            (k, number) = (k + 1, number + 1);
        }
        group += 1;
    }
    keys
}

/// Keys of the groups `gravity`, `fluid`, `domain` and `background`.
const OF_FLUID: &[Key] = &[
    key(
        "gravity",
        Kind::Vector,
        Described("none"),
        "acceleration of gravity, which acts on bodies with a density or a mass",
    ),
    key(
        "fluid.viscosity",
        Kind::Positive,
        Value("1"),
        "dynamic viscosity",
    ),
    key(
        "fluid.density",
        Kind::NonNegative,
        Described("0"),
        "density of the fluid, for the buoyancy of bodies with a density",
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
    key(
        "background.kind",
        Kind::Word(BackgroundKind::WORDS),
        Described("required in `[background]`"),
        "flow in the absence of the bodies; in unbounded fluid it is the flow far away, in a \
         container the walls move with it; `poiseuille` needs the domain cylinder, whose wall is \
         at rest",
    ),
    key(
        "background.velocity",
        Kind::Vector,
        Described("required for uniform and poiseuille"),
        "velocity; of `poiseuille`: on the axis of the tube and along it, twice the mean",
    ),
    key(
        "background.gradient",
        Kind::Matrix,
        Described("required for shear and extension"),
        "rows of the gradient `G` of the velocity `u_i = sum_j G_ij x_j`; its trace is zero, and \
         for `extension` it is symmetric",
    ),
];

/// Keys of the groups `model` and `fem`.
const OTHERS: &[Key] = &[
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
         `kanchi-masud`, and for the mesh of a file `biharmonic` and other methods before the fluid \
         inside its walls is remeshed; the rest is for comparison",
    ),
    key(
        "fem.mesher",
        Kind::Word(MesherKind::WORDS),
        Value("auto"),
        "`gmsh`: where the fluid inside the walls of a mesh file cannot be remeshed otherwise, the \
         command `gmsh` is run, which must be installed",
    ),
    key(
        "fem.mirror",
        Kind::Word(SymmetryKind::WORDS),
        Value("auto"),
        "`auto` finds the coordinate planes through the origin about which bodies, loads, slip, \
         background flow and domain are symmetric for the whole run, and meshes one side of each: \
         a half or a quarter of the degrees of freedom; output shows the whole fluid",
    ),
    key(
        "fem.flows",
        Kind::Word(FlowsKind::WORDS),
        Value("phase"),
        "flows that a run writes for ParaView: the last one that is solved in each phase, all of \
         the trajectory, or none",
    ),
];
