//! Errors of the crate.

/// A mesh that cannot follow its bodies, with the offending numbers and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AleError {
    /// A moved mesh with an inverted element.
    #[error("the moved mesh is not valid ({0}); remesh at the new shape")]
    Invalid(#[from] mesh::MeshError),
    /// A body whose surface the mesh does not have.
    #[error("the surface of a moving body: {0}")]
    NoSurface(mesh::MeshError),
    /// Two bodies with the same surface.
    #[error("two moving bodies have the surface '{tag}'; give each body a surface of its own")]
    SharedSurface {
        /// Boundary tag of the surface.
        tag: String,
    },
    /// A list of the wrong length.
    #[error("expected {expected} {what}, found {found}")]
    Length {
        /// Name of the items that are counted.
        what: &'static str,
        /// Number of vertices of the mesh.
        expected: usize,
        /// Number found.
        found: usize,
    },
    /// A displacement, centre or motion that is not finite.
    #[error("{what} {index} is not finite")]
    NotFinite {
        /// Name of the item.
        what: &'static str,
        /// Index of the item.
        index: usize,
    },
    /// A rotation that is not one.
    #[error("the rotation of body {body} is a quaternion of length {length}, which must be 1")]
    NotRotation {
        /// Index of the body.
        body: usize,
        /// Length of the quaternion.
        length: f64,
    },
    /// A number of motions other than the number of bodies.
    #[error("expected {expected} motions, one per body, found {found}")]
    Motions {
        /// Number of moving bodies.
        expected: usize,
        /// Number of motions given.
        found: usize,
    },
    /// A number of twists other than the number of bodies.
    #[error("expected {expected} twists, one per body, found {found}")]
    Twists {
        /// Number of moving bodies.
        expected: usize,
        /// Number of twists given.
        found: usize,
    },
    /// A parameter of a method outside its range.
    #[error("{name} is {value}; it must be {range}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The valid range.
        range: &'static str,
    },
    /// A boundary with too many vertices for radial basis functions.
    #[error(
        "the boundary has {centres} vertices, more than the limit of {limit} for radial basis \
         functions; use another mesh motion"
    )]
    TooManyCentres {
        /// Vertices on the boundary.
        centres: usize,
        /// Largest number supported.
        limit: usize,
    },
    /// An interpolation problem without a unique solution.
    #[error(
        "the interpolation by radial basis functions is singular; \
         look for coincident boundary vertices"
    )]
    Singular,
    /// An assembly that failed.
    #[error(transparent)]
    Fem(#[from] fem::FemError),
    /// A solver that failed on the equations of the extension.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
}
