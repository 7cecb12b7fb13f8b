//! What can go wrong in one instantaneous solution.

/// A Stokes problem that cannot be set up or solved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StokesError {
    /// A boundary part that the mesh does not have, or a mesh that cannot be used.
    #[error(transparent)]
    Mesh(#[from] mesh::MeshError),
    /// Assembly that failed.
    #[error(transparent)]
    Fem(#[from] fem::FemError),
    /// Constraints that contradict each other, or a flow that is not determined.
    #[error(transparent)]
    Rigid(#[from] rigid::RigidError),
    /// A linear solve that failed.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
}
