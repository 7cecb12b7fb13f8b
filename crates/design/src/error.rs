//! Errors of designs, and the callbacks that stop them.

use models::ModelError;
use scene::{RheologyKind, Scene, SceneError};
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
    /// An objective whose derivatives contradict its values.
    #[error(
        "the derivative of the {what} with respect to {component} is {given}, but its values \
         change at the rate {by_differences}; correct the derivatives or leave them out"
    )]
    WrongDerivative {
        /// Cost or condition.
        what: &'static str,
        /// The component of the totals.
        component: &'static str,
        /// The derivative that the objective returns.
        given: f64,
        /// That of its values.
        by_differences: f64,
    },
    /// A design that was interrupted on request.
    #[error("interrupted after {what}")]
    Stopped {
        /// What was done.
        what: String,
    },
}

impl DesignError {
    /// [`DesignError::NotApplicable`] with the place of a key.
    pub(crate) fn not_applicable(scene: &Scene, key: &str, problem: impl Into<String>) -> Self {
        Self::NotApplicable {
            place: scene.place(key),
            problem: problem.into(),
        }
    }

    /// Refuses a fluid whose viscosity depends on the shear rate, where motions must be linear in
    /// the rates.
    pub(crate) fn check_rheology(scene: &Scene) -> Result<(), Self> {
        let kind = scene.rheology().map(|rheology| rheology.kind);
        match kind.unwrap_or(RheologyKind::Newtonian) {
            RheologyKind::Newtonian => Ok(()),
            RheologyKind::Auto | RheologyKind::Full => Err(Self::not_applicable(
                scene,
                "fluid.law",
                "the viscosity depends on the shear rate, so that the motion depends on the times of \
                 a stroke and not on its shapes alone; set fluid.rheology = \"newtonian\", or \
                 compare runs",
            )),
        }
    }

    /// [`DesignError::NoStroke`].
    pub(crate) fn no_stroke(reason: impl Into<String>) -> Self {
        Self::NoStroke {
            reason: reason.into(),
        }
    }

    /// The exit code of the `swim` command, as [`SwimError::exit_code`].
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Swim(error) => error.exit_code(),
            Self::NotApplicable { .. } => 2,
            Self::NoStroke { .. } | Self::WrongDerivative { .. } => 3,
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

/// Callbacks that inform the caller about the progress of a design, and stop the work.
#[allow(unused_variables)]
pub trait DesignProgress {
    /// Whether the work is to stop; checked after every solve and search.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// `done` of `all` parts of the work are done, such as `points` of a sweep. More can follow
    /// where the work finds out by itself how much it is, as grids of tables do. Called first
    /// before any part is computed, with those that are known already.
    fn counted(&mut self, what: &str, done: usize, all: usize) {}

    /// A part of the work begins.
    fn begins(&mut self, what: &str) {}
}

/// No callbacks.
impl DesignProgress for () {}

/// [`DesignError::Stopped`] after `what`, if the work is to stop.
pub(crate) fn check_interruption(
    progress: &dyn DesignProgress,
    what: impl FnOnce() -> String,
) -> Result<(), DesignError> {
    match progress.is_interrupted() {
        true => Err(DesignError::Stopped { what: what() }),
        false => Ok(()),
    }
}
