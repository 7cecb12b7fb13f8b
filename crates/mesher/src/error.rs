//! Errors of surfaces, mesh generation and remeshing.

use mesh::MeshError;

/// A surface or a mesh that cannot be generated, with the location and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GenerateError {
    /// A mesh that cannot be built, read or written, or a bad name.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// A body or container that is not symmetric about a symmetry plane.
    #[error(
        "'{part}' is not symmetric about the plane '{plane}' through the origin; put its centre on the \
         plane or mesh the whole fluid"
    )]
    NotSymmetric {
        /// Name of the body or of the container.
        part: String,
        /// Tag of the plane.
        plane: &'static str,
    },
    /// Triangles that are not a closed surface around a solid, or not one that can be meshed.
    #[error(
        "{surface}: triangle {triangle} near ({:.6}, {:.6}, {:.6}): {problem}", at[0], at[1], at[2]
    )]
    BadSurface {
        /// Name of the surface or of its file.
        surface: String,
        /// Number of the triangle, counted from 1 in the order of the file.
        triangle: usize,
        /// Position of the defect.
        at: [f64; 3],
        /// The problem and its remedy.
        problem: String,
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
    /// Bodies that touch or overlap, or that are too close to be meshed.
    #[error(
        "the distance between the bodies '{first}' and '{second}' is {distance:.3e}, but must be more \
         than {minimum:.1e}; move them apart"
    )]
    BodiesTouch {
        /// Name of one body.
        first: String,
        /// Name of the other body.
        second: String,
        /// Distance between the bodies, negative when they overlap.
        distance: f64,
        /// Smallest distance that can be meshed.
        minimum: f64,
    },
    /// A body that is not inside the container.
    #[error(
        "the distance of body '{body}' from the container's wall is {distance:.3e} (negative: \
         outside), but must be more than {minimum:.1e}; move it inwards or enlarge the container"
    )]
    BodyAtWall {
        /// Name of the body.
        body: String,
        /// Distance of the body from the wall, negative when they overlap.
        distance: f64,
        /// Smallest distance that can be meshed.
        minimum: f64,
    },
    /// Element sizes that need more vertices than allowed.
    #[error(
        "the element sizes need more than {limit} vertices; increase the sizes or the growth, or raise \
         the limit"
    )]
    TooManyVertices {
        /// Largest allowed number of vertices.
        limit: usize,
    },
    /// Points that lie in one plane.
    #[error("{points} points lie in one plane and span no tetrahedra")]
    FlatPoints {
        /// Number of points.
        points: usize,
    },
    /// Triangles of a mesh that no new mesh around them could be generated with.
    #[error(
        "no new mesh has the triangles of {part} near ({:.4}, {:.4}, {:.4}) as faces; refine the \
         mesh of the file there, or keep the bodies away from there", at[0], at[1], at[2]
    )]
    BoundaryNotRecovered {
        /// Name of the body, or the walls.
        part: String,
        /// Position of the failure.
        at: [f64; 3],
    },
    /// The command `gmsh` made no mesh.
    #[error(
        "gmsh made no mesh: {problem}; install Gmsh (for example by `pip install gmsh`) so that its \
         command is found, or choose fem.mesher = \"auto\""
    )]
    Gmsh {
        /// What went wrong, in its own words if it gave any.
        problem: String,
    },
    /// A surface that the faces of the generated tets do not follow.
    #[error(
        "the mesh near ({:.4}, {:.4}, {:.4}) does not follow the surface of '{body}'; use a smaller \
         element size on it, or a less slender shape",
        at[0], at[1], at[2]
    )]
    SurfaceNotRecovered {
        /// Name of the body or container.
        body: String,
        /// Position of the failure.
        at: [f64; 3],
    },
}
