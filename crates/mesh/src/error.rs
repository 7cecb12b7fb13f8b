//! Errors of mesh construction, reading and writing.

use std::path::PathBuf;

/// A mesh that cannot be built, read or written, with the location and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// A cell whose geometry map is not one-to-one.
    #[error(
        "cell {cell} near ({:.4}, {:.4}, {:.4}) is inverted: its smallest scaled Jacobian is \
         {jacobian:.3e}; use smaller elements there or remesh", at[0], at[1], at[2]
    )]
    InvertedCell {
        /// Index of the cell.
        cell: usize,
        /// Its centroid.
        at: [f64; 3],
        /// Lower bound of the Jacobian determinant over the cell, divided by six times the volume
        /// of the straight cell.
        jacobian: f64,
    },
    /// A node of the boundary part on a symmetry plane that is not in the plane.
    #[error(
        "node {node} of the boundary part '{plane}' is {distance:.3e} away from its plane, which goes \
         through the origin; translate the mesh"
    )]
    OffSymmetryPlane {
        /// Number of the node.
        node: usize,
        /// Tag of the plane.
        plane: &'static str,
        /// Its distance.
        distance: f64,
    },
    /// A mesh without cells.
    #[error(
        "the mesh has no tetrahedra; mesh the volume, and if only physical groups are saved give the \
         fluid one"
    )]
    Empty,

    /// More nodes or cells than 31-bit numbers can index.
    #[error(
        "the mesh has {count} {what}, more than the {} that its numbering can hold",
        i32::MAX
    )]
    TooLarge {
        /// Name of the items.
        what: &'static str,
        /// Number of items.
        count: usize,
    },
    /// A coordinate that is NaN or infinite.
    #[error(
        "coordinates of point {point} are not finite in double precision; correct them, or use \
         other units of length"
    )]
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// A tet or face that refers to a point or tag that does not exist.
    #[error("{what} {index} refers to number {number}, but there are only {len}")]
    OutOfRange {
        /// "tet", "face", "tag of face" or "region of tet".
        what: &'static str,
        /// Index of the item.
        index: usize,
        /// The number to which it refers.
        number: usize,
        /// Number of points, tags or regions.
        len: usize,
    },
    /// A tet without volume.
    #[error(
        "tet {cell} near ({:.4}, {:.4}, {:.4}) has no volume: its vertices lie in one plane; remove or remesh it",
        at[0], at[1], at[2]
    )]
    FlatCell {
        /// Index of the tet in the input.
        cell: usize,
        /// Its centroid.
        at: [f64; 3],
    },
    /// Two tets with the same vertices.
    #[error(
        "a tet near ({:.4}, {:.4}, {:.4}) occurs twice; remove one",
        at[0], at[1], at[2]
    )]
    DuplicateCell {
        /// Its centroid.
        at: [f64; 3],
    },
    /// A vertex that belongs to no tet.
    #[error(
        "vertex {vertex} at ({:.4}, {:.4}, {:.4}) belongs to no tetrahedron; remove it",
        at[0], at[1], at[2]
    )]
    UnusedVertex {
        /// Index of the vertex in the input.
        vertex: usize,
        /// Position of the vertex.
        at: [f64; 3],
    },
    /// Two vertices at the same position.
    #[error(
        "vertices {first} and {second} are both at ({:.4}, {:.4}, {:.4}); merge them \
         (Gmsh: \"Coherence Mesh\")", at[0], at[1], at[2]
    )]
    DuplicateVertices {
        /// Index of one vertex in the input.
        first: usize,
        /// Index of the other vertex.
        second: usize,
        /// Their position.
        at: [f64; 3],
    },
    /// A face that three or more tets share.
    #[error(
        "{cells} tetrahedra share the face near ({:.4}, {:.4}, {:.4}), but at most two can; the mesh \
         overlaps itself there",
        at[0], at[1], at[2]
    )]
    NonManifoldFace {
        /// Number of tets that share the face.
        cells: usize,
        /// Centroid of the face.
        at: [f64; 3],
    },
    /// A boundary face that belongs to no boundary part.
    #[error(
        "the boundary face near ({:.4}, {:.4}, {:.4}) has no tag; give every surface of the fluid a \
         name (Gmsh: a physical group), or close the gap if there should be no boundary", at[0], at[1], at[2]
    )]
    UntaggedFace {
        /// Centroid of the face.
        at: [f64; 3],
    },
    /// A tagged face that does not bound the fluid.
    #[error(
        "the face of '{tag}' near ({:.4}, {:.4}, {:.4}) is not a boundary face: it belongs to {cells} \
         tetrahedra instead of one; tag surfaces of the fluid only, and mesh the fluid only", at[0], at[1], at[2]
    )]
    NotOnBoundary {
        /// Name of the part.
        tag: String,
        /// Number of tets with this face: 0 or 2.
        cells: usize,
        /// Centroid of the face.
        at: [f64; 3],
    },
    /// A boundary face that is tagged twice.
    #[error(
        "the face near ({:.4}, {:.4}, {:.4}) is tagged twice, '{first}' and '{second}'; keep one",
        at[0], at[1], at[2]
    )]
    FaceTaggedTwice {
        /// Name of one tag.
        first: String,
        /// Name of the other tag, which may be the same.
        second: String,
        /// Centroid of the face.
        at: [f64; 3],
    },
    /// A boundary part that the mesh does not have.
    #[error("the mesh has no boundary part '{name}'; it has: {}", known.join(", "))]
    UnknownTag {
        /// The unknown name.
        name: String,
        /// The names of all boundary parts.
        known: Vec<String>,
    },
    /// A boundary part with a bad or duplicate name, or without faces.
    #[error("boundary part '{name}' {problem}")]
    BadTag {
        /// Name of the part.
        name: String,
        /// The problem and its remedy.
        problem: &'static str,
    },
    /// A region of the volume with a bad or duplicate name.
    #[error("region '{name}' {problem}")]
    BadRegion {
        /// Name of the region.
        name: String,
        /// The problem and its remedy.
        problem: &'static str,
    },
    /// A boundary node that is not on the surface given for its part.
    #[error(
        "node at ({:.6}, {:.6}, {:.6}) of '{tag}' is {distance:.3e} away from the surface given for \
         it (allowed: {allowed:.1e}); correct the shape, position or size of '{tag}'", at[0], at[1], at[2]
    )]
    OffSurface {
        /// Name of the part.
        tag: String,
        /// Position of the node.
        at: [f64; 3],
        /// Distance of the node from the surface.
        distance: f64,
        /// Largest allowed distance, which covers the rounding of mesh files.
        allowed: f64,
    },
    /// A surface whose functions contradict each other.
    #[error(
        "for the point ({:.6}, {:.6}, {:.6}) the {what} is {found:e}, but must be {expected:e} \
         ({reason}; allowed difference {allowed:.1e}): correct the functions of the surface", at[0], at[1], at[2]
    )]
    InconsistentSurface {
        /// The number that was computed.
        what: &'static str,
        /// Why it must have this value.
        reason: &'static str,
        /// The point.
        at: [f64; 3],
        /// The number.
        found: f64,
        /// The number that it should be.
        expected: f64,
        /// Largest allowed difference.
        allowed: f64,
    },
    /// Midside nodes that do not fit the vertices.
    #[error(
        "midside node near ({:.4}, {:.4}, {:.4}): {problem}; the second-order mesh is not conforming",
        at[0], at[1], at[2]
    )]
    BadMidside {
        /// Position of the node.
        at: [f64; 3],
        /// The problem.
        problem: &'static str,
    },
    /// An array whose length does not fit the mesh.
    #[error("{what} has {found} entries, but the mesh needs {expected}")]
    WrongLength {
        /// Name of the array.
        what: String,
        /// Number of entries that the mesh needs.
        expected: usize,
        /// Number of entries found.
        found: usize,
    },
    /// A field with a value that is NaN or infinite.
    #[error("{what} has the value {value} at entry {index}; no file was written")]
    BadValue {
        /// Name of the field.
        what: String,
        /// Index of the entry.
        index: usize,
        /// The value.
        value: f64,
    },
    /// Two fields of the same name.
    #[error("the file already has a field '{name}'; give every field its own name")]
    DuplicateField {
        /// The name of both fields.
        name: String,
    },
    /// A malformed or unsupported mesh file.
    #[error("{file}: {location}: {problem}")]
    Malformed {
        /// Path of the file.
        file: String,
        /// Line of a text file, offset of a binary one.
        location: FileLocation,
        /// The problem and its remedy.
        problem: String,
    },
    /// A file that cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file name whose extension is not that of a mesh format.
    #[error("{}: unknown file extension; use .msh or .vtu", path.display())]
    UnknownFormat {
        /// Path of the file.
        path: PathBuf,
    },
    /// A file name whose extension is not that of a surface format.
    #[error("{}: unknown file extension; use .stl, .obj or .msh", path.display())]
    UnknownSurfaceFormat {
        /// Path of the file.
        path: PathBuf,
    },
    /// A length or coefficient outside its range.
    #[error("{what} is {value}; {requirement}")]
    BadParameter {
        /// Name of the parameter.
        what: String,
        /// Value of the parameter.
        value: f64,
        /// The range of allowed values.
        requirement: &'static str,
    },
}

/// Location of an error in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FileLocation {
    /// Line of a text file, counted from 1.
    Line(usize),
    /// Byte offset in a binary file, counted from 0.
    Byte(usize),
}

impl std::fmt::Display for FileLocation {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Byte(offset) => write!(f, "byte {offset}"),
        }
    }
}
