//! Errors between a scene file and its results.

use std::path::PathBuf;

use inertia::InertiaError;
use models::ModelError;
use scene::SceneError;

/// A scene that cannot be used or a simulation that failed, with the place and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SwimError {
    /// A scene that cannot be used.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A model that was created for another scene.
    #[error(
        "the model '{model}' was created for a scene with another {key}; create the model of the \
         scene that is to be simulated"
    )]
    OtherScene {
        /// Name of the model.
        model: &'static str,
        /// First key in which the scenes differ.
        key: String,
    },
    /// An integration method without steps.
    #[error("the integration method has zero steps per leg; it needs at least one")]
    NoSteps,
    /// An integration with the inertia of the fluid without a fluid.
    #[error(
        "the method Unsteady needs the flow of a fluid with inertia; give it by \
         Integrator::with_unsteady_scene, and set fluid.inertia in the scene"
    )]
    NoFlow,
    /// A step in time of a fluid with inertia that cannot be taken.
    #[error(transparent)]
    Inertia(InertiaError),
    /// A file that cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Reason given by the operating system.
        source: std::io::Error,
    },
    /// A file or folder that cannot be written.
    #[error("cannot write {}: {source}; choose another place with --out", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Reason given by the operating system.
        source: std::io::Error,
    },
    /// A folder into which another run is writing.
    #[error(
        "another run ({process}) writes into {}; wait until it ends, or choose another folder with \
         --out", folder.display()
    )]
    Locked {
        /// The folder.
        folder: PathBuf,
        /// The process in words.
        process: String,
    },
    /// Bodies that touch each other or a wall during the motion.
    #[error("phase {phase} ({joint}, {percent:.1} % done, time {time:.6}): {problem}; {remedy}")]
    Collision {
        /// Number of the phase, from one, over all cycles.
        phase: usize,
        /// Name of the joint that changes its value.
        joint: String,
        /// Completed part of the phase, in percent.
        percent: f64,
        /// The time, in the scene's units.
        time: f64,
        /// The bodies or the wall that touch, with the gap.
        problem: String,
        /// What to change.
        remedy: &'static str,
    },
    /// Bodies that approach each other or a wall, ever more slowly, so that they never touch.
    #[error(
        "phase {phase} ({joint}, {percent:.1} % done, time {time:.6}): {bodies} are pressed \
         together: the gap is {gap:.2e} and closes at the speed {speed:.2e}. By lubrication it \
         decreases by a factor of e per {decay:.2e} of time and never vanishes; it reaches \
         {smallest:.0e}, the smallest gap that is computed, at the time {until:.6}. End the run \
         before, or change the load"
    )]
    Approach {
        /// Number of the phase, from one, over all cycles.
        phase: usize,
        /// Name of the joint that changes its value.
        joint: String,
        /// Completed part of the phase, in percent.
        percent: f64,
        /// The time, in the scene's units.
        time: f64,
        /// The bodies, or the body and the wall, in words.
        bodies: String,
        /// The gap that was reached.
        gap: f64,
        /// Speed at which it closes there.
        speed: f64,
        /// Time in which it decreases by a factor of e.
        decay: f64,
        /// The smallest gap that is computed.
        smallest: f64,
        /// Time at which the gap is expected to reach it.
        until: f64,
    },
    /// A gait that cannot be integrated to the tolerance.
    #[error(
        "phase {phase} ({joint}): the integration error is {error:.3e} and must be below \
         {tolerance:.3e} (both in the scene's unit of length), even with 1/{parts} of the phase \
         per step; increase model.tolerance{hint}"
    )]
    NotIntegrated {
        /// Number of the phase, from one, over all cycles.
        phase: usize,
        /// Name of the joint that changes its value.
        joint: String,
        /// Estimated error of the displacement.
        error: f64,
        /// Largest error allowed.
        tolerance: f64,
        /// Number of steps of the smallest tried length in the phase.
        parts: usize,
        /// What else may be the cause, or nothing.
        hint: &'static str,
    },
    /// A gait whose passive joints do not reach a periodic state.
    #[error(
        "gait.periodic: after {cycles} cycles the values of the passive joints still change by \
         {mismatch:.1e} per cycle (in the scene's unit of length); use stiffer springs, a gait that \
         closes, or start from the positions without gait.periodic"
    )]
    NotPeriodic {
        /// Number of cycles tried.
        cycles: usize,
        /// Change per cycle, as a displacement of the bodies.
        mismatch: f64,
    },
    /// A gait in a fluid with inertia that does not reach a periodic state.
    #[error(
        "gait.periodic: after {cycles} cycles the displacement still differs by {residual:.1e} from \
         that of the cycle before (in the scene's unit of length; {allowed:.1e} is allowed), and the \
         kinetic energy by {energy_residual:.1e} of its largest value ({energy_allowed:.1e}); \
         bodies near a wall, in gravity or with a net force have no periodic state, and heavy \
         bodies, soft springs and cycles shorter than the time in which vorticity leaves the \
         swimmer need more cycles: use a larger domain or model.tolerance, lighter bodies, stiffer \
         springs or a slower gait, or run several cycles without gait.periodic"
    )]
    NotPeriodicFlow {
        /// Number of cycles tried.
        cycles: usize,
        /// Difference of the displacements of the last two cycles.
        residual: f64,
        /// Difference of the kinetic energies before and after the last cycle, relative.
        energy_residual: f64,
        /// Largest allowed difference of the displacements.
        allowed: f64,
        /// Largest allowed difference of the kinetic energies.
        energy_allowed: f64,
    },
    /// A finished run whose error bar is larger than the tolerance; its files are written.
    #[error(
        "the error bar of the net displacement is {error:.1e}, and model.tolerance = \
         {tolerance:e} allows {allowed:.1e}; increase model.tolerance, or accept the result with \
         model.accept = \"best\""
    )]
    ToleranceMissed {
        /// Error bar of the net displacement that the tolerance limits.
        error: f64,
        /// The tolerance of the scene.
        tolerance: f64,
        /// Largest error bar allowed, [`Outcome::allowed_error`].
        ///
        /// [`Outcome::allowed_error`]: crate::Outcome::allowed_error
        allowed: f64,
    },
    /// Explicit steps with which velocities would grow without bound.
    #[error(
        "phase {phase} ({joint}): the explicit step {step:.3e} exceeds the stability limit \
         {limit:.3e}, twice the shortest relaxation time m/R; take at least {steps} steps per \
         phase, or an implicit method"
    )]
    Unstable {
        /// Number of the phase, from one, over all cycles.
        phase: usize,
        /// Name of the joint that changes its value.
        joint: String,
        /// Length of the step.
        step: f64,
        /// Largest stable length of a step.
        limit: f64,
        /// Smallest stable number of steps per phase, a whole number.
        steps: f64,
    },
    /// A model that cannot be used for the scene, or that failed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A checkpoint from which the run cannot continue.
    #[error("{} {problem}; run without --resume to start from the beginning", path.display())]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// The defect.
        problem: String,
    },
    /// A run that was interrupted on request.
    #[error(
        "interrupted after {phases} of {all} phases; repeat the command with --resume to continue"
    )]
    Interrupted {
        /// Number of completed phases.
        phases: usize,
        /// Number of all phases.
        all: usize,
    },
    /// A command that does not apply to the scene.
    #[error("{place}: {problem}")]
    NotApplicable {
        /// The scene file and key, or the argument.
        place: String,
        /// The reason and the remedy.
        problem: String,
    },
    /// Files of the caller ([`RunFiles`](crate::RunFiles)) that cannot be made.
    #[error(transparent)]
    Files(Box<dyn std::error::Error + Send + Sync>),
}

impl SwimError {
    /// Whether a shorter step may avoid the error: bodies that touch, or impossible lengths.
    pub(crate) fn is_overshoot(&self) -> bool {
        match self {
            Self::Collision { .. } => true,
            Self::Model(error) => error.is_overshoot(),
            _ => false,
        }
    }

    /// Whether a step in time fails that a shorter one may not.
    pub(crate) fn needs_shorter_step(&self) -> bool {
        match self {
            Self::Inertia(error) => error.needs_shorter_step(),
            Self::Model(error) => error.needs_shorter_step(),
            _ => false,
        }
    }

    /// Whether the motion up to the error is a result: the motion itself ended, by contact or where
    /// it could not be computed any further.
    pub(crate) fn ends_motion(&self) -> bool {
        match self {
            Self::Collision { .. }
            | Self::Approach { .. }
            | Self::NotIntegrated { .. }
            | Self::Inertia(_)
            | Self::Unstable { .. } => true,
            Self::Model(error) => !error.is_bad_input(),
            _ => false,
        }
    }

    /// The exit code of the `swim` command: 2 for bad input, 3 for a failed method, 130 when
    /// interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Model(error) if !error.is_bad_input() => 3,
            Self::Collision { .. }
            | Self::Approach { .. }
            | Self::NotIntegrated { .. }
            | Self::NotPeriodic { .. }
            | Self::NotPeriodicFlow { .. }
            | Self::ToleranceMissed { .. }
            | Self::Unstable { .. }
            | Self::Inertia(_)
            | Self::Files(_) => 3,
            // The code that shells report for a program ended by Ctrl-C.
            Self::Interrupted { .. } => 130,
            // Without a wildcard, so that a new variant needs a decision.
            Self::Scene(_)
            | Self::Model(_)
            | Self::Read { .. }
            | Self::Write { .. }
            | Self::Locked { .. }
            | Self::Checkpoint { .. }
            | Self::OtherScene { .. }
            | Self::NoSteps
            | Self::NoFlow
            | Self::NotApplicable { .. } => 2,
        }
    }
}

impl From<rigid::RigidError> for SwimError {
    fn from(error: rigid::RigidError) -> Self {
        Self::Model(error.into())
    }
}

impl From<InertiaError> for SwimError {
    fn from(error: InertiaError) -> Self {
        match error {
            InertiaError::Supplier(inner) => match inner.downcast::<ModelError>() {
                Ok(error) => Self::Model(*error),
                Err(other) => Self::Inertia(InertiaError::Supplier(other)),
            },
            other => Self::Inertia(other),
        }
    }
}
