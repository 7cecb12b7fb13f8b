//! The seam between phase spans in a fluid with inertia and what takes the steps.

use std::f64::consts::PI;
use std::sync::{PoisonError, RwLock};

use axisymmetric::AxialState;
use inertia::IntegratorState;
use models::{InstantaneousSolution, MeshOrigin, ModelError};
use rigid::StateVelocity;
use scene::{PhaseSpan, Scene};
use serde::{Deserialize, Serialize};

use crate::added_mass::AddedMassForces;
use crate::error::SwimError;
use crate::kinetic_energy::KineticEnergy;

/// A fluid that remembers its velocity, and the bodies in it, which take steps in time together.
///
/// All numbers are in the units of the scene. It begins at rest at the time zero.
pub(super) trait MovingFluid {
    /// The present time.
    fn time(&self) -> f64;

    /// Continues along a phase span.
    fn enter(&mut self, span: &PhaseSpan);

    /// Replaces the velocity by that without inertia, with the rates of a phase span at its start.
    ///
    /// # Errors
    /// Those of assembly and linear solve.
    fn start_from_stokes(&mut self, span: &PhaseSpan) -> Result<(), SwimError>;

    /// Forgets all but the present velocity, after which derivatives may jump.
    fn restart(&mut self);

    /// Takes a step of this length without accepting it.
    ///
    /// # Errors
    /// [`SwimError::needs_shorter_step`] if no mesh can follow a step of this length, or it is not
    /// solved.
    fn try_step(&mut self, length: f64) -> Result<TriedStep, SwimError>;

    /// Largest factor from one step to the next, below `1 + 2^(1/2)`, up to which BDF2 with
    /// variable steps is stable (Grigorieff 1983).
    fn max_growth(&self) -> f64 {
        2.0
    }

    /// The solution at the end of the step that was tried last, with its flow if that is known on a
    /// mesh in space.
    ///
    /// # Errors
    /// [`SwimError::NoFlow`] before a step.
    fn solution(&mut self, with_flow: bool) -> Result<InstantaneousSolution, SwimError>;

    /// Forces that the bodies exert on the fluid because they accelerate, at the end of the step
    /// that was tried last; none between the times at which two flows meet.
    ///
    /// # Errors
    /// [`SwimError::NoFlow`] before a step; those of assembly and linear solve.
    fn added_mass_forces(&self) -> Result<Option<AddedMassForces>, SwimError>;

    /// Accepts the step that was tried last.
    ///
    /// # Errors
    /// [`SwimError::NoFlow`] before a step.
    fn accept(&mut self) -> Result<(), SwimError>;

    /// Kinetic energy of fluid and bodies at the present time.
    ///
    /// # Errors
    /// A velocity that is not finite.
    fn kinetic_energy(&self) -> Result<KineticEnergy, SwimError>;

    /// What the next steps depend on. The fluid goes on with the same bits as one that continues
    /// from it.
    ///
    /// # Errors
    /// [`SwimError::NoFlow`] before a mesh.
    fn remembered(&mut self) -> Result<FluidState, SwimError>;

    /// Continues from what a fluid of the same scene remembered.
    ///
    /// # Errors
    /// What does not fit the scene.
    fn continue_from(&mut self, state: FluidState) -> Result<(), SwimError>;
}

/// What a fluid with inertia remembers between two phase spans, for checkpoints.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct UnsteadyState {
    pub(super) fluid: FluidState,
    /// Time of the fluid at the start of the gait; before it are cycles of the search for a
    /// periodic state.
    #[serde(default)]
    pub(super) origin: f64,
    /// Length of the last step that its error chose.
    pub(super) length: Option<f64>,
    /// Estimated error of the velocities of surfaces so far.
    pub(super) velocity_error: f64,
}

/// What a moving fluid remembers between steps.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum FluidState {
    Spatial(MeshOrigin, IntegratorState),
    Meridian(AxialState),
    WithCompanion(Box<[FluidState; 2]>),
}

/// The error for what a fluid of another discretisation remembered.
pub(super) fn other_discretisation() -> SwimError {
    ModelError::History("has the fluid of another discretisation".to_owned()).into()
}

/// Shortest step relative to the phase.
pub(super) const LEAST_STEP: f64 = 1e-9;

/// Part of a step below which it is not halved again: a failure that does not depend on the length
/// is then found after 16 attempts.
pub(super) const LEAST_PART: f64 = 1.0 / 65536.0;

/// A step in time, before it is accepted.
pub(super) struct TriedStep {
    pub length: f64,
    /// The change of the state.
    pub increment: StateVelocity,
    /// Estimated error of this change by the mesh, which was subtracted from it.
    pub mesh_error: Option<MeshError>,
    /// Estimated error of the velocities by the step, relative to the largest ones; infinite where
    /// nothing is known of it.
    pub error: f64,
    /// Estimated displacement that the error of the step costs, which chooses its length; infinite
    /// as `error`.
    pub displacement_error: f64,
    /// Estimated error of the velocities of surfaces by the step; infinite as `error`, zero where
    /// `mesh_error` contains the errors of steps.
    pub velocity_error: f64,
    /// Error of the velocities of bodies by a new mesh at the start of the step.
    pub jump: f64,
}

/// Error of the change of the state in a step by the mesh.
pub(super) struct MeshError {
    /// The error.
    pub change: StateVelocity,
    /// Its relative uncertainty, the same in all steps.
    pub relative_uncertainty: f64,
    /// That of this step in addition.
    pub own_uncertainty: f64,
}

/// Times after which the velocity of the slowest body does not know any more how it began.
///
/// After an impulse the velocity decays within `m / (6π μ a)` by the drag, and within the time
/// `ρ a² / μ` in which vorticity leaves the body, after which it is below `t^(-3/2)` (Hinch 1975).
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyMemory {
    /// By the diffusion of vorticity.
    pub diffusion: f64,
    /// By the mass of the body.
    pub inertia: f64,
}

impl BodyMemory {
    pub fn new(scene: &Scene) -> Self {
        let of_body = |body: &scene::Body| {
            let (radius, mass) = (body.bounding_radius(), body.mass_matrix_by_density());
            let mass = mass.map_or(0.0, |(mass, _)| mass);
            // points have neither
            let inertia = if radius > 0.0 {
                mass / (6.0 * PI * radius)
            } else {
                0.0
            };
            [scene.fluid_density() * radius * radius, inertia]
        };
        let slowest = (scene.bodies().iter().map(of_body))
            .fold([0.0_f64; 2], |[a, b], [c, d]| [a.max(c), b.max(d)]);
        let [diffusion, inertia] = slowest.map(|time| time / scene.viscosity());
        Self { diffusion, inertia }
    }

    /// Both together.
    pub fn total(&self) -> f64 {
        self.diffusion + self.inertia
    }
}

/// Position on a phase span at a time.
pub(super) fn position(span: &PhaseSpan, time: f64) -> f64 {
    ((time - span.start) / span.duration).clamp(0.0, 1.0)
}

/// The phase span that is integrated; none before the first.
#[derive(Default)]
pub(super) struct PresentSpan(RwLock<Option<PhaseSpan>>);

impl PresentSpan {
    /// Continues along a phase span.
    pub fn enter(&self, span: &PhaseSpan) {
        // No value is half written if a thread panics here.
        let mut present = self.0.write().unwrap_or_else(PoisonError::into_inner);
        *present = Some(span.clone());
    }

    /// Values of the joints at a time; those at the start of the scene before the first span.
    pub fn shape(&self, scene: &Scene, time: f64) -> Vec<f64> {
        let span = self.0.read().unwrap_or_else(PoisonError::into_inner);
        match &*span {
            Some(span) => span.shape(position(span, time)),
            None => scene.articulation().initial_shape().to_vec(),
        }
    }
}
