//! Errors of the command.

use design::DesignError;
use pictures::PictureError;
use swimmer::models::ModelError;
use swimmer::{SceneError, SwimError};

/// Why the command ends without a result.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    #[error(transparent)]
    Swim(#[from] SwimError),
    #[error(transparent)]
    Design(#[from] DesignError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A result that cannot be written to stdout.
    #[error("cannot write the result to standard output: {0}; free space there, or redirect it")]
    Output(std::io::Error),
    /// A solution whose error bar is larger than the tolerance that the user asks for.
    #[error(
        "{place}: model.tolerance = {tolerance:e} allows an error bar of the {quantity} of \
         {allowed:.1e}, {error:.1e} was reached; {remedy}, or accept the result with \
         model.accept = \"best\""
    )]
    ToleranceMissed {
        place: String,
        tolerance: f64,
        quantity: &'static str,
        allowed: f64,
        error: f64,
        remedy: &'static str,
    },
    /// Arguments that do not apply, with the reason and the remedy.
    #[error("{place}: {problem}")]
    NotApplicable { place: String, problem: String },
}

impl CliError {
    /// 2 for bad input, 3 for a failed method, 130 when interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Swim(error) => error.exit_code(),
            Self::Design(error) => error.exit_code(),
            Self::Picture(error) => error.exit_code(),
            Self::ToleranceMissed { .. } => 3,
            Self::Output(_) | Self::NotApplicable { .. } => 2,
        }
    }
}

impl From<SceneError> for CliError {
    fn from(error: SceneError) -> Self {
        Self::Swim(error.into())
    }
}

impl From<ModelError> for CliError {
    fn from(error: ModelError) -> Self {
        Self::Swim(error.into())
    }
}
