//! Integration of the motion along the phase spans of a gait.
//!
//! In a Newtonian fluid without inertia the velocity is linear in the rates of the joints, so the
//! displacement over a phase span depends on the path through shape space and not on the speed.
//! [`Method::Collocation`] solves at a few Gauss points of the phase span, at the rates there;
//! where the motion does not depend on the position, this is Gauss quadrature of a line integral.

mod brownian;
mod collocation;
mod companion;
mod euler;
mod inertia;
mod inverse_dexp;
mod masses;
mod meridian_fluid;
mod moving_fluid;
mod order_errors;
mod passive_joints;
mod piece;
mod prediction;
mod radau;
mod result;
mod runge_kutta;
mod span_evaluator;
mod spatial_fluid;
mod step_size;
mod unsteady;

pub(crate) use brownian::noise_steps;
pub(crate) use collocation::TABLE_SHARE;
pub(crate) use companion::{COARSER, share_of_sizes};
use inertia::Scheme;
pub(crate) use masses::relaxation_time;
use masses::{Velocities, at_rest};
use models::Hydrodynamics;
use nalgebra::Vector6;
use prediction::Prediction;
use rigid::State;
use scene::{AcceptKind, ModelKind, PhaseSpan, Scene};
use span_evaluator::SpanEvaluator;

pub(crate) use prediction::velocity_tolerance;

pub use moving_fluid::UnsteadyState;
pub use piece::PathPiece;
pub use result::SpanResult;
pub(crate) use span_evaluator::enter_table;
pub use span_evaluator::{ObserveSolution, SpanSolution};
pub use unsteady::UnsteadyScene;

use crate::error::SwimError;
use crate::moment::check_model;
use unsteady::UnsteadyFlow;

/// Number of solves of a typical phase span by collocation: orders of one, two and three points.
pub const TYPICAL_SOLVES_PER_SPAN: usize = 6;

/// Integration method along a phase span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// Gauss collocation in rotation-vector coordinates about the middle of the step, with as many
    /// points as the tolerance needs. The order is `2n` with `n` points; the method is symmetric,
    /// so the reversed stroke returns along the same path.
    Collocation,
    /// The Runge-Kutta pair of Dormand & Prince on the group of states, with step size control:
    /// order 5.
    RungeKutta,
    /// Explicit Euler with a given number of steps per phase span: first order, for comparison.
    Euler {
        /// Number of equal steps.
        steps: usize,
    },
    /// The Radau IIA method of order 5 for bodies with mass and moment of inertia, with as many
    /// steps as the tolerance needs.
    Inertia,
    /// Backward Euler with the masses and moments of inertia of the bodies: first order, stable for
    /// steps of any length.
    BackwardEuler {
        /// Number of equal steps.
        steps: usize,
    },
    /// Explicit Euler with masses and moments of inertia, for comparison: refuses steps beyond its
    /// stability limit, twice the shortest relaxation time.
    ExplicitInertia {
        /// Number of equal steps.
        steps: usize,
    },
    /// Equal steps of the midpoint method of Fixman, for thermal noise (`fluid.thermal_energy`):
    /// the order in distribution is one, and two where the noise is small.
    Brownian,
    /// Steps in time of fluid and bodies together, for fluids with inertia
    /// ([`Integrator::with_unsteady_scene`]): BDF2 with as many steps as the tolerance needs, or of
    /// the length `fluid.time_step`.
    Unsteady,
}

impl Method {
    /// The method for a scene: [`Method::Unsteady`] if the fluid has inertia, [`Method::Inertia`]
    /// if bodies have mass; [`Method::Brownian`] with thermal noise; [`Method::RungeKutta`] for
    /// many swimmers that repel each other, of which some meet at any time, where orders above five
    /// gain nothing; else [`Method::Collocation`].
    pub fn from_scene(scene: &Scene) -> Self {
        if scene.noise().is_some() {
            return Self::Brownian;
        }
        match (scene.inertia().is_kept(), scene.has_masses()) {
            (true, _) => Self::Unsteady,
            (false, true) => Self::Inertia,
            (false, false) if is_repelling_swarm(scene) => Self::RungeKutta,
            (false, false) => Self::Collocation,
        }
    }

    /// Whether the masses of bodies enter, so that their velocities are part of the state.
    pub(crate) fn has_inertia(self) -> bool {
        match self {
            Self::Inertia
            | Self::BackwardEuler { .. }
            | Self::ExplicitInertia { .. }
            | Self::Unsteady => true,
            Self::Collocation | Self::RungeKutta | Self::Euler { .. } | Self::Brownian => false,
        }
    }

    /// Refuses a method without steps, and one that neglects thermal noise or needs it.
    ///
    /// # Errors
    /// [`SwimError::NoSteps`], [`SwimError::NotApplicable`].
    pub(crate) fn check(self, scene: &Scene) -> Result<(), SwimError> {
        if (self == Self::Brownian) != scene.noise().is_some() {
            return Err(SwimError::NotApplicable {
                place: scene.place("fluid.thermal_energy"),
                problem: format!(
                    "thermal noise needs the method Brownian, which is for it alone, not {self:?}"
                ),
            });
        }
        match self {
            Self::Euler { steps: 0 }
            | Self::BackwardEuler { steps: 0 }
            | Self::ExplicitInertia { steps: 0 } => Err(SwimError::NoSteps),
            _ => Ok(()),
        }
    }
}

/// Number of bodies from which on some meet at any time.
///
/// Sixty spheres that settle take 53 solves by the Runge-Kutta pair and 115 by collocation to the
/// same tolerance, sixty squirmers 438 and 2281.
const MANY: usize = 10;

/// Whether many spheres without joints repel each other, by a model of point forces.
///
/// The pair has no corrections of elements, does not accept the best of what it can reach, and does
/// not return along the path of a reversed stroke.
fn is_repelling_swarm(scene: &Scene) -> bool {
    let kind = scene.model().kind;
    let has_point_forces =
        matches!(kind, ModelKind::Rpy | ModelKind::Oseen) || scene.domain().period().is_some();
    scene.repulsion().is_some()
        && scene.bodies().len() >= MANY
        && scene.articulation().joints().is_empty()
        && !scene.has_held_bodies()
        && scene.shortest_period().is_none()
        && has_point_forces
        && scene.model().accept == AcceptKind::Tolerance
}

/// Integrates the motion of a scene's bodies phase span by phase span.
pub struct Integrator<'a> {
    scene: &'a Scene,
    model: &'a mut dyn Hydrodynamics,
    method: Method,
    /// Velocities of the bodies at the end of the last phase span, for methods with inertia; none
    /// at rest.
    velocities: Option<Velocities>,
    /// Integration error that the scene's tolerance allows for a phase span, if it is predicted.
    span_tolerance: Option<f64>,
    /// Whether solutions are shown with their flow.
    flows: bool,
    /// Longest relaxation time of a body.
    relaxation: f64,
    /// Fluid and bodies so far, for fluids with inertia.
    unsteady: Option<UnsteadyFlow<'a>>,
    /// The part of the last phase span before an error that ended its motion.
    so_far: Option<SpanResult>,
}

impl<'a> Integrator<'a> {
    /// An integrator of the motion of `scene` with the velocities of `model`.
    pub fn new(scene: &'a Scene, model: &'a mut dyn Hydrodynamics, method: Method) -> Self {
        Self {
            scene,
            model,
            method,
            velocities: None,
            span_tolerance: Prediction::from_scene(scene)
                .map(|prediction| prediction.span_tolerance(scene.working_tolerance())),
            flows: false,
            relaxation: relaxation_time(scene),
            unsteady: None,
            so_far: None,
        }
    }

    /// The same integrator, which shows solutions with or without their flow to observers.
    #[must_use]
    pub fn with_flows(self, flows: bool) -> Self {
        Self { flows, ..self }
    }

    /// The same integrator for a fluid with inertia that is at rest at the start of the gait, or in
    /// Stokes flow (`fluid.start`).
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    pub fn with_unsteady_scene(self, scene: &'a UnsteadyScene) -> Result<Self, SwimError> {
        let unsteady = Some(UnsteadyFlow::new(scene)?);
        Ok(Self { unsteady, ..self })
    }

    /// The same integrator after `span`, with the fluid as [`SpanResult::fluid`] of it.
    ///
    /// # Errors
    /// [`SwimError::NoFlow`] without [`Integrator::with_unsteady_scene`], a fluid that does not fit
    /// the scene or the end of `span`.
    pub fn after(mut self, span: &PhaseSpan, fluid: UnsteadyState) -> Result<Self, SwimError> {
        let unsteady = self.unsteady.as_mut().ok_or(SwimError::NoFlow)?;
        unsteady.continue_after(span, fluid)?;
        Ok(self)
    }

    /// Continues with the first phase span of the gait after the last one, at the time zero;
    /// `fluid` is that at the end of the last one, and becomes that at the start of the first one.
    ///
    /// # Errors
    /// [`SwimError::NoFlow`] without [`Integrator::with_unsteady_scene`].
    pub(crate) fn begin_again(&mut self, fluid: &mut UnsteadyState) -> Result<(), SwimError> {
        let unsteady = self.unsteady.as_mut().ok_or(SwimError::NoFlow)?;
        unsteady.begin_again(fluid);
        Ok(())
    }

    /// The same integrator for bodies with mass that have these velocities `(U, ω)`, six numbers
    /// per body; bodies at rest for another number of them.
    #[must_use]
    pub fn with_velocities(mut self, velocities: &[f64]) -> Self {
        let (bodies, []) = velocities.as_chunks::<6>() else {
            return self;
        };
        self.velocities = (bodies.len() == self.scene.bodies().len())
            .then(|| bodies.iter().map(|body| Vector6::from(*body)).collect());
        self
    }

    /// The model.
    pub fn model(&mut self) -> &mut dyn Hydrodynamics {
        self.model
    }

    /// Moves the bodies from `start` along a phase span; `observe` is called with every solution
    /// and the model.
    ///
    /// # Errors
    /// [`SwimError::OtherScene`], [`SwimError::NoSteps`], [`SwimError::NoFlow`], those of the
    /// model, [`SwimError::Collision`], [`SwimError::Approach`], [`SwimError::NotIntegrated`],
    /// [`SwimError::Unstable`], and errors of `observe`.
    pub fn span(
        &mut self,
        span: &PhaseSpan,
        start: &State,
        observe: ObserveSolution,
    ) -> Result<SpanResult, SwimError> {
        check_model(self.scene, self.model)?;
        self.method.check(self.scene)?;
        // The model starts each phase span from its history alone, so a resumed run gives the same
        // digits.
        let history = self.model.history()?;
        self.model.restore(&history)?;
        let mut evaluator =
            SpanEvaluator::new(self.scene, self.model, span, self.span_tolerance, observe);
        evaluator.flows = self.flows;
        evaluator.relaxation = self.relaxation;
        let before = self.velocities.clone();
        let integrated = match self.method {
            Method::Collocation => collocation::span(&mut evaluator, start),
            Method::RungeKutta => runge_kutta::span(&mut evaluator, start),
            Method::Euler { steps } => euler::span(&mut evaluator, start, steps),
            Method::Inertia => radau::span(&mut evaluator, start, &mut self.velocities),
            Method::BackwardEuler { steps } => inertia::span(
                &mut evaluator,
                start,
                steps,
                Scheme::Implicit,
                &mut self.velocities,
            ),
            Method::ExplicitInertia { steps } => inertia::span(
                &mut evaluator,
                start,
                steps,
                Scheme::Explicit,
                &mut self.velocities,
            ),
            Method::Brownian => match self.scene.noise() {
                Some(noise) => brownian::span(&mut evaluator, start, noise),
                None => Err(SwimError::NoSteps.into()),
            },
            Method::Unsteady => {
                let unsteady = self.unsteady.as_mut().ok_or(SwimError::NoFlow)?;
                unsteady::span(&mut evaluator, start, unsteady)
            }
        };
        integrated.map_err(|stopped| {
            // An error before the first step, such as contact at an impulse of the joints.
            let nothing = || {
                let empty = SpanResult::empty(start);
                let empty = match self.method.has_inertia() {
                    true => empty.with_velocities(&before.unwrap_or_else(|| at_rest(self.scene))),
                    false => empty,
                };
                stopped.error.ends_motion().then_some(empty)
            };
            self.so_far = stopped.so_far.map(|result| *result).or_else(nothing);
            *stopped.error
        })
    }

    /// The first part of a phase span whose motion ended with an error, such as
    /// [`SwimError::Collision`]; it ends at [`SpanResult::reached`].
    pub fn take_so_far(&mut self) -> Option<SpanResult> {
        self.so_far.take()
    }
}
