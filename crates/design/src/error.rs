//! Errors of the design of strokes.

use models::ModelError;
use scene::SceneError;
use swimmer::SwimError;

/// A design that is not possible or that failed, with the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DesignError {
    /// A scene that cannot be used, a model or a run that failed, a file.
    #[error(transparent)]
    Swim(#[from] SwimError),
    /// A design that does not apply to the scene.
    #[error("{place}: {problem}")]
    NotApplicable {
        /// The scene file and key.
        place: String,
        /// The reason and the remedy.
        problem: String,
    },
    /// A search for strokes that found none.
    #[error("no optimal stroke: {reason}")]
    NoStroke {
        /// The reason and the remedy.
        reason: String,
    },
    /// A design that was interrupted on request.
    #[error("interrupted after {what}")]
    Stopped {
        /// What was done.
        what: String,
    },
}

impl DesignError {
    /// The exit code of the `swim` command, as [`SwimError::exit_code`].
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Swim(error) => error.exit_code(),
            Self::NotApplicable { .. } => 2,
            Self::NoStroke { .. } => 3,
            // The code that shells report for a program ended by Ctrl-C.
            Self::Stopped { .. } => 130,
        }
    }
}

impl From<SceneError> for DesignError {
    fn from(error: SceneError) -> Self {
        Self::Swim(error.into())
    }
}

impl From<ModelError> for DesignError {
    fn from(error: ModelError) -> Self {
        Self::Swim(error.into())
    }
}

impl From<rigid::RigidError> for DesignError {
    fn from(error: rigid::RigidError) -> Self {
        Self::Swim(error.into())
    }
}
