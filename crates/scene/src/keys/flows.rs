//! The keys of flows that do not come from links: gravity, background flow, slip.

use super::key::KeyDefault::Described;
use super::key::{Key, Kind};
use super::table::key;
use crate::words::BackgroundKind;

pub(super) const GRAVITY: Key = key(
    "gravity",
    Kind::Vector,
    Described("none"),
    "acceleration of gravity, which acts on bodies with a density",
);

pub(super) const FLUID_DENSITY: Key = key(
    "fluid.density",
    Kind::NonNegative,
    Described("zero: no buoyancy"),
    "density of the fluid, for the buoyancy of bodies with a density",
);

pub(super) const BACKGROUND_KIND: Key = key(
    "background.kind",
    Kind::Word(BackgroundKind::WORDS),
    Described("required in `[background]`"),
    "flow in the absence of the bodies; in unbounded fluid it is the flow far away, in a \
     container the walls move with it; `poiseuille` needs the domain cylinder, whose wall is \
     at rest",
);

pub(super) const BACKGROUND_VELOCITY: Key = key(
    "background.velocity",
    Kind::Vector,
    Described("required for uniform and poiseuille"),
    "velocity; of `poiseuille`: on the axis of the tube and along it, twice the mean",
);

pub(super) const BACKGROUND_GRADIENT: Key = key(
    "background.gradient",
    Kind::Matrix,
    Described("required for shear and extension"),
    "rows of the gradient `G` of the velocity `u_i = sum_j G_ij x_j`; its trace is zero, and \
     for `extension` it is symmetric",
);

pub(super) const BODY_DENSITY: Key = key(
    "bodies[].density",
    Kind::NonNegative,
    Described("that of the fluid: no weight"),
    "density; with `gravity` g the force (density - fluid.density) volume g acts on the centre \
     of the body, beside `force`; it has no inertia",
);

pub(super) const SLIP_B1: Key = key(
    "bodies[].slip.b1",
    Kind::Number,
    Described("zero"),
    "first mode of the tangential velocity `-(b1 + b2 n·k) (I - n n^T) k` of the surface, with \
     the outward normal n and the unit vector k along `axis`: on a sphere `b1 sin θ`",
);

pub(super) const SLIP_B2: Key = key(
    "bodies[].slip.b2",
    Kind::Number,
    Described("zero"),
    "second mode: on a sphere `b2 sin θ cos θ`; positive for pullers, negative for pushers",
);

pub(super) const SLIP_AXIS: Key = key(
    "bodies[].slip.axis",
    Kind::Vector,
    Described("`[1, 0, 0]`"),
    "direction of the axis k in the initial configuration; it turns with the body",
);
