//! Errors of pictures.

use std::path::PathBuf;

use models::ModelError;
use scene::SceneError;
use swimmer::SwimError;

/// A picture that cannot be drawn, with the reason.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// A run that failed, or a file of it.
    #[error(transparent)]
    Swim(#[from] SwimError),
    /// A plot that cannot be drawn.
    #[error("cannot draw the trajectory: {0}")]
    Plot(String),
    /// A run without a flow that a movie could show.
    #[error("--movie {}: the run has no flow in a plane: {reason}", folder.display())]
    NoFlow {
        /// The folder of the run.
        folder: PathBuf,
        /// The reason and the remedy.
        reason: String,
    },
}

impl PictureError {
    /// The exit code of the `swim` command, as [`SwimError::exit_code`].
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Swim(error) => error.exit_code(),
            Self::Plot(_) => 3,
            Self::NoFlow { .. } => 2,
        }
    }
}

impl From<SceneError> for PictureError {
    fn from(error: SceneError) -> Self {
        Self::Swim(error.into())
    }
}

impl From<ModelError> for PictureError {
    fn from(error: ModelError) -> Self {
        Self::Swim(error.into())
    }
}

impl From<rigid::RigidError> for PictureError {
    fn from(error: rigid::RigidError) -> Self {
        Self::Swim(error.into())
    }
}

/// For the files of a run ([`swimmer::RunFiles`]).
impl From<PictureError> for SwimError {
    fn from(error: PictureError) -> Self {
        match error {
            PictureError::Swim(error) => error,
            error => Self::Files(Box::new(error)),
        }
    }
}
