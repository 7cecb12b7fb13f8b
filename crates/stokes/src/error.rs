//! Errors of setting up and solving a Stokes problem.

/// A Stokes problem that cannot be set up or solved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StokesError {
    /// A boundary part that the mesh does not have, or an unusable mesh.
    #[error(transparent)]
    Mesh(#[from] mesh::MeshError),
    /// A part of the boundary that is given twice.
    #[error("the boundary part '{name}' is given twice; it is one body or one wall")]
    PartTwice {
        /// Name of the part.
        name: String,
    },
    /// A failed assembly.
    #[error(transparent)]
    Fem(#[from] fem::FemError),
    /// Contradictory constraints, or a flow that is not unique.
    #[error(transparent)]
    Rigid(#[from] rigid::RigidError),
    /// A failed linear solve.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
    /// A failure of an [`Engine`](crate::Engine).
    #[error(transparent)]
    Engine(Box<dyn std::error::Error + Send + Sync>),
    /// A boundary velocity with a net flux through the boundary of an enclosed domain.
    #[error(
        "the prescribed velocity has the net flux {flux:.3e} out of the domain ({:.1} % of the \
         sum of absolute fluxes); prescribe a velocity without net flux", 100.0 * relative
    )]
    NetFlux {
        /// Net flux out of the domain.
        flux: f64,
        /// The same divided by the sum of the absolute fluxes at the vertices.
        relative: f64,
    },
}
