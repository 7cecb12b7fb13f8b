//! The keys of bodies.

use super::key::KeyDefault::{Described, Value};
use super::key::{Key, Kind};
use super::table::key;
use crate::words::{ShapeKind, SurfaceKind};

/// Keys of the group `bodies`, in the order in which scenes are written.
pub(super) const OF_BODIES: &[Key] = &[
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
        "shape; surface: a closed surface in a file of its own; file: the part of the mesh's \
         boundary named by `surface`, as it is; point: a massless joint without a surface",
    ),
    key(
        "bodies[].radius",
        Kind::Positive,
        Described("required unless the shape is ellipsoid, surface, file or point"),
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
        "bodies[].file",
        Kind::Text,
        Described("required for surface"),
        "STL, OBJ or Gmsh file of a closed surface, oriented outwards; a relative path starts at \
         the folder of the scene file",
    ),
    key(
        "bodies[].surface_kind",
        Kind::Word(SurfaceKind::WORDS),
        Described("`smooth`, for a surface"),
        "smooth: curved through the vertices of the triangles, with edges of more than 40 degrees \
         between their normals kept sharp; faceted: flat triangles",
    ),
    key(
        "bodies[].scale",
        Kind::Positive,
        Described("1, for a surface"),
        "length of the scene per length of the file",
    ),
    key(
        "bodies[].centre",
        Kind::Vector,
        Described("centroid of the volume"),
        "point of a surface that is at `position` and about which it turns, in coordinates of the \
         file",
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
        Described("required; of `shape = \"file\"` the centroid of its volume"),
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
        "bodies[].density",
        Kind::NonNegative,
        Described("that of the fluid: no weight"),
        "density; with `gravity` g the force (density - fluid.density) volume g acts on the centre \
         of volume of the body, beside `force`; it has no inertia",
    ),
    key(
        "bodies[].slip.b1",
        Kind::Number,
        Described("0"),
        "first mode of the tangential velocity `-(b1 + b2 n·k) (I - n n^T) k` of the surface, with \
         the outward normal n and the unit vector k along `axis`: on a sphere `b1 sin θ`",
    ),
    key(
        "bodies[].slip.b2",
        Kind::Number,
        Described("0"),
        "second mode: on a sphere `b2 sin θ cos θ`; positive for pullers, negative for pushers",
    ),
    key(
        "bodies[].slip.axis",
        Kind::Vector,
        Described("[1, 0, 0]"),
        "direction of the axis k in the initial configuration; it turns with the body",
    ),
    key(
        "bodies[].mass",
        Kind::NonNegative,
        Value("0"),
        "mass; without masses there is no inertia. With gravity its weight is that of the mass \
         minus that of the displaced fluid; give mass or density, not both",
    ),
    key(
        "bodies[].inertia",
        Kind::NonNegative,
        Value("0"),
        "moment of inertia about the centre; for zero that of a homogeneous body of the mass",
    ),
];
