//! What can go wrong between a scene file and its results.

use std::path::PathBuf;

use scene::SceneError;

use models::ModelError;

/// A scene that cannot be used or a simulation that failed, with the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SwimError {
    /// A scene that cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A file that cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A file or folder that cannot be written.
    #[error("cannot write {}: {source}; choose another place with --out", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// Bodies that came too close to each other or to a wall while they moved.
    #[error(
        "phase {phase} ({what} at {percent:.1} %, time {time:.6}): {problem}; shorten the stroke or give the bodies more room"
    )]
    Collision {
        /// Number of the phase, from one, over all cycles.
        phase: usize,
        /// What the phase moves.
        what: String,
        /// How far into the phase.
        percent: f64,
        /// The time, in the scene's units.
        time: f64,
        /// Who touches what, with the gap.
        problem: String,
    },
    /// A gait that cannot be integrated to the tolerance.
    #[error(
        "phase {phase} ({what}): the integration still errs by {error:.3e} where {tolerance:.3e} was asked, \
         on a step of 1/{parts} of the phase; loosen model.tolerance or refine fem.surface_size"
    )]
    NotIntegrated {
        /// Number of the phase, from one, over all cycles.
        phase: usize,
        /// What the phase moves.
        what: String,
        /// Estimated error of the displacement.
        error: f64,
        /// What was asked.
        tolerance: f64,
        /// One over the smallest step tried, in phases.
        parts: usize,
    },
    /// Explicit steps that would let velocities grow without bound.
    #[error(
        "phase {phase} ({what}): explicit steps with inertia must be shorter than {limit:.3e}, twice the shortest relaxation time m/R; \
         these are {step:.3e}: take {steps} steps a phase, or an implicit method"
    )]
    Unstable {
        /// Number of the phase, from one, over all cycles.
        phase: usize,
        /// What the phase moves.
        what: String,
        /// The step.
        step: f64,
        /// What it must stay below.
        limit: f64,
        /// Steps a phase that would do, a whole number.
        steps: f64,
    },
    /// A model that cannot be used for the scene, or that failed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A checkpoint that cannot be gone on from.
    #[error("{} {problem}; run without --resume to start anew", path.display())]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        problem: String,
    },
    /// Somebody asked the run to end.
    #[error(
        "interrupted after {phases} of {all} phases; the same command with --resume goes on from there"
    )]
    Interrupted {
        /// Phases that are done.
        phases: usize,
        /// All phases.
        all: usize,
    },
    /// A command that does not fit the scene.
    #[error("{place}: {problem}")]
    NotApplicable {
        /// The scene file.
        place: String,
        /// What is missing or too much, and what to do.
        problem: String,
    },
    /// A picture that could not be drawn.
    #[error("cannot draw the trajectory: {0}")]
    Picture(String),
}

impl SwimError {
    /// The exit code of the `swim` command: 2 for bad input, 3 for a method that failed, 130 when interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Model(error) if !error.is_bad_input() => 3,
            Self::Collision { .. }
            | Self::NotIntegrated { .. }
            | Self::Unstable { .. }
            | Self::Picture(_) => 3,
            // What shells answer for a program that Ctrl-C ended.
            Self::Interrupted { .. } => 130,
            _ => 2,
        }
    }
}

impl From<rigid::RigidError> for SwimError {
    fn from(error: rigid::RigidError) -> Self {
        Self::Model(error.into())
    }
}
