//! What can go wrong with a mesh.

use std::path::PathBuf;

/// A mesh that cannot be made, read or used, with the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A cell whose geometry map is not one-to-one.
    #[error(
        "cell {cell} near ({:.4}, {:.4}, {:.4}) is inverted: smallest Jacobian {jacobian:.3e} of its mean; \
         use smaller elements there or remesh", at[0], at[1], at[2]
    )]
    InvertedCell {
        /// Index of the cell.
        cell: usize,
        /// Its centroid.
        at: [f64; 3],
        /// Lower bound of the Jacobian determinant over the cell, divided by six times the straight volume.
        jacobian: f64,
    },

    /// A node on a mirror plane that is not where the plane is.
    #[error(
        "node {node} of the boundary '{plane}' is {distance:.3e} away from that plane, which goes through the origin; move the mesh there"
    )]
    OffSymmetryPlane {
        /// Number of the node.
        node: usize,
        /// Tag of the plane.
        plane: &'static str,
        /// Its distance.
        distance: f64,
    },

    /// A body or container that is not its own image in a mirror plane.
    #[error(
        "'{part}' is not its own mirror image in the plane '{plane}' through the origin; put its centre on the plane or mesh the whole"
    )]
    NotSymmetric {
        /// Name of the body or of the container.
        part: String,
        /// Tag of the plane.
        plane: &'static str,
    },

    /// A mesh without cells.
    #[error(
        "the mesh has no tetrahedra; mesh a volume, and if it was saved by groups give the fluid a group"
    )]
    Empty,

    /// More nodes or cells than 31-bit numbers can count.
    #[error(
        "the mesh has {count} {what}, more than the {} that its numbering can hold",
        i32::MAX
    )]
    TooLarge {
        /// What there are too many of.
        what: &'static str,
        /// How many.
        count: usize,
    },

    /// A number that is NaN or infinite.
    #[error("coordinates of point {point} are not finite")]
    NotFinite {
        /// Index of the point.
        point: usize,
    },

    /// A tet or face that refers to a point or tag that does not exist.
    #[error("{what} {index} refers to number {number}, but there are only {len}")]
    OutOfRange {
        /// "tet", "face" or "tag of face".
        what: &'static str,
        /// Its index.
        index: usize,
        /// The number it holds.
        number: usize,
        /// How many there are.
        len: usize,
    },

    /// A tet without volume.
    #[error(
        "tet {cell} near ({:.4}, {:.4}, {:.4}) has no volume: its vertices lie in one plane; remove or remesh it",
        at[0], at[1], at[2]
    )]
    FlatCell {
        /// Index of the tet as given.
        cell: usize,
        /// Its centroid.
        at: [f64; 3],
    },

    /// Two tets with the same vertices.
    #[error("a tet near ({:.4}, {:.4}, {:.4}) is there twice; remove one", at[0], at[1], at[2])]
    DuplicateCell {
        /// Its centroid.
        at: [f64; 3],
    },

    /// A vertex that no tet uses.
    #[error(
        "vertex {vertex} at ({:.4}, {:.4}, {:.4}) belongs to no tetrahedron; remove it",
        at[0], at[1], at[2]
    )]
    UnusedVertex {
        /// Index of the vertex as given.
        vertex: usize,
        /// Where it is.
        at: [f64; 3],
    },

    /// Two vertices at one place.
    #[error(
        "vertices {first} and {second} are both at ({:.4}, {:.4}, {:.4}); merge them \
         (Gmsh: \"Coherence Mesh\")", at[0], at[1], at[2]
    )]
    DuplicateVertices {
        /// Index of one as given.
        first: usize,
        /// Index of the other.
        second: usize,
        /// Where they are.
        at: [f64; 3],
    },

    /// A face that three or more tets share.
    #[error(
        "{cells} tetrahedra share the face near ({:.4}, {:.4}, {:.4}), where two can; the mesh overlaps itself there",
        at[0], at[1], at[2]
    )]
    NonManifoldFace {
        /// How many share it.
        cells: usize,
        /// Centroid of the face.
        at: [f64; 3],
    },

    /// A boundary face that no part of the boundary claims.
    #[error(
        "the boundary face near ({:.4}, {:.4}, {:.4}) has no tag; give every surface of the fluid a name \
         (Gmsh: a physical group), or close the gap if none should be there", at[0], at[1], at[2]
    )]
    UntaggedFace {
        /// Centroid of the face.
        at: [f64; 3],
    },

    /// A tagged face that does not bound the fluid.
    #[error(
        "the face of '{tag}' near ({:.4}, {:.4}, {:.4}) is no boundary face: it belongs to {cells} tetrahedra \
         instead of one; tag surfaces of the fluid only, and mesh the fluid only", at[0], at[1], at[2]
    )]
    NotOnBoundary {
        /// Name of the part.
        tag: String,
        /// Tets that have this face: 0 or 2.
        cells: usize,
        /// Centroid of the face.
        at: [f64; 3],
    },

    /// A boundary face that is listed twice.
    #[error(
        "the face near ({:.4}, {:.4}, {:.4}) is tagged twice, '{first}' and '{second}'; keep one",
        at[0], at[1], at[2]
    )]
    FaceTaggedTwice {
        /// One name.
        first: String,
        /// The other (or the same).
        second: String,
        /// Centroid of the face.
        at: [f64; 3],
    },

    /// A part of the boundary that no list knows.
    #[error("the mesh has no boundary part '{name}'; it has: {}", known.join(", "))]
    UnknownTag {
        /// The name asked for.
        name: String,
        /// The names there are.
        known: Vec<String>,
    },

    /// Two parts of one name, or a part without faces.
    #[error("boundary part '{name}' {problem}")]
    BadTag {
        /// Name of the part.
        name: String,
        /// What is wrong with it.
        problem: &'static str,
    },

    /// A boundary node that is not on the surface given for its part.
    #[error(
        "node at ({:.6}, {:.6}, {:.6}) of '{tag}' is {distance:.3e} away from the surface given for it \
         (allowed: {allowed:.1e}); correct the shape, position or size of '{tag}'", at[0], at[1], at[2]
    )]
    OffSurface {
        /// Name of the part.
        tag: String,
        /// Where the node is.
        at: [f64; 3],
        /// Its distance from the surface.
        distance: f64,
        /// The largest distance taken for rounding.
        allowed: f64,
    },

    /// Midside nodes that do not fit the vertices.
    #[error(
        "the edge midpoint near ({:.4}, {:.4}, {:.4}): {problem}; the second-order mesh is not conforming",
        at[0], at[1], at[2]
    )]
    BadMidside {
        /// Where the node is.
        at: [f64; 3],
        /// What is wrong with it.
        problem: &'static str,
    },

    /// An array whose length does not fit the mesh.
    #[error("{what} has {found} entries, but the mesh asks for {expected}")]
    WrongLength {
        /// Name of the array.
        what: String,
        /// Entries needed.
        expected: usize,
        /// Entries given.
        found: usize,
    },

    /// A field with a value that is NaN or infinite.
    #[error("{what} has the value {value} at entry {index}; nothing is written")]
    BadValue {
        /// Name of the field.
        what: String,
        /// Index of the entry.
        index: usize,
        /// The value.
        value: f64,
    },

    /// A malformed or unsupported mesh file.
    #[error("{file}: {place}: {problem}")]
    Malformed {
        /// Path of the file.
        file: String,
        /// Line of a text file, offset of a binary one.
        place: Place,
        /// What is wrong, with the remedy.
        problem: String,
    },

    /// A file that cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },

    /// A file name whose ending names no format.
    #[error("{}: cannot tell the format; end the name in .msh or .vtu", path.display())]
    UnknownFormat {
        /// Path of the file.
        path: PathBuf,
    },

    /// A length or coefficient that makes no sense.
    #[error("{what} is {value}; {need}")]
    BadParameter {
        /// Which one.
        what: String,
        /// Its value.
        value: f64,
        /// What it must be.
        need: &'static str,
    },

    /// Bodies that touch or overlap, or that are too close to be meshed apart.
    #[error(
        "bodies '{first}' and '{second}' are {distance:.3e} apart, which must be more than {least:.1e}; move them apart"
    )]
    BodiesTouch {
        /// Name of one.
        first: String,
        /// Name of the other.
        second: String,
        /// Their distance, negative when they overlap.
        distance: f64,
        /// The least distance that can be meshed.
        least: f64,
    },

    /// A body that is not inside the container.
    #[error(
        "body '{body}' is {distance:.3e} from the container's wall (negative: outside), which must be more than {least:.1e}; move it inwards or enlarge the container"
    )]
    BodyAtWall {
        /// Name of the body.
        body: String,
        /// Its distance to the wall, negative when it crosses it.
        distance: f64,
        /// The least distance that can be meshed.
        least: f64,
    },

    /// Sizes that ask for more vertices than allowed.
    #[error(
        "the sizes ask for more than {limit} vertices; enlarge the sizes or the growth, or raise the limit"
    )]
    TooManyVertices {
        /// The limit.
        limit: usize,
    },

    /// Points that span no volume.
    #[error("{points} points lie in one plane and span no tetrahedra")]
    FlatPoints {
        /// How many points there are.
        points: usize,
    },

    /// A surface triangulation that the tets do not contain.
    #[error(
        "the mesh near ({:.4}, {:.4}, {:.4}) does not follow the surface of '{body}'; use a smaller size on it, or a less slender shape",
        at[0], at[1], at[2]
    )]
    SurfaceNotRecovered {
        /// Name of the body or container.
        body: String,
        /// Where.
        at: [f64; 3],
    },
}

/// A place in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Line of a text file, counted from 1.
    Line(usize),
    /// Offset in a binary file, in bytes from 0.
    Byte(usize),
}

impl std::fmt::Display for Place {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
        }
    }
}
