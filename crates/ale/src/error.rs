//! What can go wrong when a mesh is moved.

/// A mesh that cannot follow its bodies, with the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum AleError {
    /// The moved mesh is not valid.
    #[error("the moved mesh is not valid ({0}); remesh at the new shape")]
    Invalid(#[from] mesh::MeshError),
    /// An array whose length does not fit.
    #[error("expected {expected} motions, one a body, found {found}")]
    Motions {
        /// Number of moving bodies.
        expected: usize,
        /// Number of motions given.
        found: usize,
    },
    /// A parameter of a method outside its range.
    #[error("{name} is {value}, it must be {range}")]
    Parameter {
        /// Which one.
        name: &'static str,
        /// What it is.
        value: f64,
        /// What it may be.
        range: &'static str,
    },
    /// A boundary too fine for radial basis functions.
    #[error(
        "the boundary has {centres} vertices, radial basis functions take {most} at most; use another mesh motion"
    )]
    TooManyCentres {
        /// Vertices on the boundary.
        centres: usize,
        /// The most there may be.
        most: usize,
    },
    /// An interpolation problem without a unique solution.
    #[error(
        "the boundary's vertices do not determine an interpolation by radial basis functions; look for coincident vertices"
    )]
    Singular,
    /// Assembly failed.
    #[error(transparent)]
    Fem(#[from] fem::FemError),
    /// The extension equations could not be solved.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
}
