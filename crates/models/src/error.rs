//! Errors of models of the flow.

use nalgebra::DMatrix;

/// A model that cannot be used for a scene, or a computation that failed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A value of the scene that the model does not support.
    #[error("{what} is not supported; {instead}")]
    Unsupported {
        /// The unsupported key and value.
        what: String,
        /// What to use instead.
        instead: String,
    },
    /// Values or rates of the joints that the bodies of the scene do not allow.
    #[error(transparent)]
    Scene(#[from] Box<scene::SceneError>),
    /// Bodies and joints that contradict each other.
    #[error(transparent)]
    Rigid(#[from] rigid::RigidError),
    /// A mesh that cannot be generated, moved, read or written.
    #[error(transparent)]
    Mesh(#[from] mesher::GenerateError),
    /// A mesh that cannot follow the bodies.
    #[error(transparent)]
    Ale(#[from] ale::AleError),
    /// A failed assembly.
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
    /// A part of the boundary of a mesh that is neither a body nor a wall.
    #[error(
        "{file}: the boundary part '{tag}' is neither the surface of a body nor in domain.walls; \
         list it in domain.walls, or name it by the key surface of a body{}",
        absent(missing)
    )]
    OpenBoundary {
        /// The mesh file.
        file: String,
        /// Name of the part.
        tag: String,
        /// Names in the scene that no part of the boundary has.
        missing: Vec<String>,
    },
    /// A mesh file whose mesh cannot be used.
    #[error("{file}: {source}")]
    MeshFile {
        /// The mesh file.
        file: String,
        /// The defect.
        source: Box<mesh::MeshError>,
    },
    /// Bodies that moved too far for the mesh of a file.
    #[error(
        "the mesh of the file cannot follow the bodies this far ({tried}), and there is no new mesh \
         between its walls and the bodies: {source}; or use a mesh file of another configuration"
    )]
    MeshFileExhausted {
        /// The methods that were tried to move the mesh, each with the reason why it failed.
        tried: String,
        /// Why the fluid could not be meshed again.
        source: mesher::GenerateError,
    },
    /// A table over shapes that cannot be computed.
    #[error("shape space: {problem}")]
    ShapeSpace {
        /// The reason and the remedy.
        problem: String,
    },
    /// A table over shapes of which other computations solve a part.
    #[error(
        "{missing} of the {} shapes of the grid {} are missing; solve all shares of \
         it first",
        points.iter().product::<usize>(), product(points)
    )]
    MissingShapes {
        /// Number of shapes that are not known.
        missing: usize,
        /// Points of the grid in each variable.
        points: Vec<usize>,
    },
    /// A history that does not fit the model.
    #[error("the history of the model {0}")]
    History(String),
    /// A symmetric matrix that is not positive definite.
    #[error("the {matrix} is not positive definite (smallest eigenvalue {smallest:.3e}); {remedy}")]
    NotPositiveDefinite {
        /// Name of the matrix.
        matrix: &'static str,
        /// Smallest eigenvalue; NaN if the matrix is not finite.
        smallest: f64,
        /// What to change.
        remedy: &'static str,
    },
    /// A matrix that is singular in double precision.
    #[error(
        "the {matrix} ({size} x {size}) is singular, so the correction for unbounded fluid cannot \
         be applied; refine the mesh or use domain.kind = \"ball\""
    )]
    Singular {
        /// Name of the matrix.
        matrix: &'static str,
        /// Number of rows.
        size: usize,
    },
    /// A solution with another number of bodies or linkages than the scene.
    #[error("the model '{model}' returned {found} {what}, the scene has {expected}")]
    WrongCount {
        /// Name of the model.
        model: &'static str,
        /// Name of the items.
        what: &'static str,
        /// Number in the solution.
        found: usize,
        /// Number in the scene.
        expected: usize,
    },
    /// A model that returned no solution for a query.
    #[error("the model '{model}' returned no solution")]
    NoSolution {
        /// Name of the model.
        model: &'static str,
    },
    /// An error of a model that is implemented outside this crate.
    #[error(transparent)]
    Other(Box<dyn std::error::Error + Send + Sync>),
    /// A request that needs a mesh, to a model that has none.
    #[error("the model has no mesh; solve for a configuration first, or use model.kind = \"fem\"")]
    NoMesh,
    /// A solution with a number that is not finite.
    #[error(
        "the model '{model}' returned {what} that is not finite; check the sizes and units of the \
         scene"
    )]
    NotFinite {
        /// Name of the model.
        model: &'static str,
        /// The quantity.
        what: &'static str,
    },
}

impl From<mesh::MeshError> for ModelError {
    fn from(error: mesh::MeshError) -> Self {
        Self::Mesh(error.into())
    }
}

impl ModelError {
    /// The error for a value that a model does not support: "{what} is not supported; {instead}".
    pub(crate) fn unsupported(what: impl Into<String>, instead: &str) -> Self {
        Self::Unsupported {
            what: what.into(),
            instead: instead.to_owned(),
        }
    }

    /// The error for a symmetric matrix whose Cholesky factorisation failed.
    ///
    /// `name` and `remedy` complete the message "the {name} is not positive definite; {remedy}".
    pub fn not_positive_definite(
        name: &'static str,
        matrix: &DMatrix<f64>,
        remedy: &'static str,
    ) -> Self {
        // The iteration for eigenvalues may not end for a matrix that is not finite.
        let is_finite = matrix.iter().all(|entry| entry.is_finite());
        let smallest = match is_finite && matrix.is_square() && !matrix.is_empty() {
            true => matrix.symmetric_eigenvalues().min(),
            false => f64::NAN,
        };
        Self::NotPositiveDefinite {
            matrix: name,
            smallest,
            remedy,
        }
    }

    /// The error for a history that cannot be read or written.
    pub(crate) fn history(error: serde_json::Error) -> Self {
        Self::History(format!("cannot be used: {error}"))
    }

    /// Whether the configuration is one that bodies cannot reach or that the model ends before: a
    /// shorter step may avoid it.
    pub fn is_overshoot(&self) -> bool {
        matches!(
            self,
            Self::Rigid(rigid::RigidError::BadLength { .. })
                | Self::Spheres(microhydro::HydroError::GapTooNarrow { .. })
        )
    }

    /// Whether a step in time in the meridian plane fails that a shorter one may not: bodies come
    /// too close or move too far for a mesh, or the iteration does not converge.
    pub fn needs_shorter_step(&self) -> bool {
        use axisymmetric::AxisymmetricError as Axial;
        matches!(
            self,
            Self::Axisymmetric(
                Axial::MeshLost { .. }
                    | Axial::BodiesTooClose { .. }
                    | Axial::WallTooClose { .. }
                    | Axial::StepFailed { .. }
            )
        )
    }

    /// Whether the error is due to the scene or its mesh file, not to the computation.
    pub fn is_bad_input(&self) -> bool {
        use mesh::MeshError as Mesh;
        match self {
            Self::Unsupported { .. } => true,
            Self::MeshFile { .. } | Self::OpenBoundary { .. } => true,
            // Errors that only a mesh file can have.
            Self::Mesh(mesher::GenerateError::Mesh(error)) => matches!(
                error,
                Mesh::Io { .. }
                    | Mesh::Malformed { .. }
                    | Mesh::UnknownFormat { .. }
                    | Mesh::UnknownTag { .. }
                    | Mesh::BadTag { .. }
            ),
            _ => false,
        }
    }
}

/// Words about names of a scene that a mesh does not have, for messages.
fn absent(names: &[String]) -> String {
    match names {
        [] => String::new(),
        names => format!(
            "; the mesh has no part {}",
            names
                .iter()
                .map(|name| format!("'{name}'"))
                .collect::<Vec<_>>()
                .join(", ")
        ),
    }
}

/// The factors of a product, for messages.
fn product(factors: &[usize]) -> String {
    let factors: Vec<String> = factors.iter().map(ToString::to_string).collect();
    factors.join(" x ")
}
