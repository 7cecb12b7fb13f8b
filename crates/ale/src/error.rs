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
    /// Assembly failed.
    #[error(transparent)]
    Fem(#[from] fem::FemError),
    /// The extension equations could not be solved.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
}
