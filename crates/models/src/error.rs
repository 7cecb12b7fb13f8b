//! Errors of models.

use nalgebra::DMatrix;

/// A model that cannot be used for a scene, or that failed on it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// Something in the scene that the model does not support.
    #[error("{what} is not supported; {instead}")]
    Unsupported {
        /// What was asked for: a key and its value.
        what: String,
        /// What to use instead.
        instead: String,
    },
    /// Bodies and links that cannot be placed or moved.
    #[error(transparent)]
    Rigid(#[from] rigid::RigidError),
    /// A mesh that cannot be made, moved, read or written.
    #[error(transparent)]
    Mesh(#[from] mesh::MeshError),
    /// A mesh that cannot follow the bodies.
    #[error(transparent)]
    Ale(#[from] ale::AleError),
    /// Assembly that failed.
    #[error(transparent)]
    Fem(#[from] fem::FemError),
    /// Bodies on an axis whose flow cannot be computed in the meridian plane.
    #[error(transparent)]
    Axisymmetric(#[from] axisymmetric::AxisymmetricError),
    /// A Stokes problem that cannot be set up or solved.
    #[error(transparent)]
    Stokes(#[from] stokes::StokesError),
    /// Spheres whose flow cannot be computed without a mesh.
    #[error(transparent)]
    Spheres(#[from] microhydro::HydroError),
    /// A part of a mesh's boundary that is neither body nor wall.
    #[error(
        "{file}: the boundary part '{tag}' is no body's surface and not in domain.walls; \
         list it in domain.walls, or give it to a body by its key surface"
    )]
    OpenBoundary {
        /// The mesh file.
        file: String,
        /// Name of the part.
        tag: String,
    },
    /// Bodies that moved farther than the mesh of a file can be deformed.
    #[error(
        "the mesh of the file cannot follow the bodies so far without spoiling its cells; \
         use domain.kind = \"ball\" or \"box\", whose meshes are made anew when needed, or a file for another shape"
    )]
    MeshFileExhausted,
    /// A table over shapes that cannot be made.
    #[error("shape space: {problem}")]
    ShapeSpace {
        /// Why, and what to change.
        problem: String,
    },
    /// A history that does not fit the model.
    #[error("the history of the model {0}")]
    History(String),
    /// A matrix that must be positive definite and is not.
    #[error(
        "the {what} is not positive definite (smallest eigenvalue {smallest:.3e}): the bodies are \
         too close for this model; use a more accurate one"
    )]
    NotPositiveDefinite {
        /// The matrix.
        what: &'static str,
        /// Its smallest eigenvalue.
        smallest: f64,
    },
    /// A model that returned no solution for a query.
    #[error("the model '{model}' returned no solution")]
    NoSolution {
        /// Name of the model.
        model: &'static str,
    },
    /// An error of a model outside this workspace.
    #[error(transparent)]
    Other(Box<dyn std::error::Error + Send + Sync>),
    /// Work with a mesh before there is one.
    #[error("the finite-element model has no mesh yet; ask for an instant first")]
    NoMesh,
    /// An answer with a number that is not finite.
    #[error(
        "the model '{model}' answered with {what} that is not finite; check the scene's sizes and units"
    )]
    NotFinite {
        /// Name of the model.
        model: &'static str,
        /// Which number.
        what: &'static str,
    },
}

impl ModelError {
    /// A symmetric matrix whose Cholesky factorisation failed.
    pub fn not_positive_definite(what: &'static str, matrix: &DMatrix<f64>) -> Self {
        // Eigenvalues of a matrix that is not finite are not computed: the iteration may not end.
        let smallest = match matrix.iter().all(|entry| entry.is_finite()) {
            true => matrix.symmetric_eigenvalues().min(),
            false => f64::NAN,
        };
        Self::NotPositiveDefinite { what, smallest }
    }

    /// A history that cannot be read or written.
    pub(crate) fn history(error: serde_json::Error) -> Self {
        Self::History(format!("cannot be used: {error}"))
    }

    /// Whether the scene, not the method, is at fault.
    pub fn is_bad_input(&self) -> bool {
        use mesh::MeshError as Mesh;
        match self {
            Self::Unsupported { .. } => true,
            // What only a mesh file can be wrong in.
            Self::Mesh(error) => matches!(
                error,
                Mesh::Io { .. }
                    | Mesh::Malformed { .. }
                    | Mesh::UnknownFormat { .. }
                    | Mesh::Empty
                    | Mesh::UnknownTag { .. }
                    | Mesh::BadTag { .. }
                    | Mesh::UntaggedFace { .. }
                    | Mesh::NotOnBoundary { .. }
                    | Mesh::FaceTaggedTwice { .. }
                    | Mesh::OffSurface { .. }
            ),
            _ => false,
        }
    }
}
