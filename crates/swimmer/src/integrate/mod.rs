//! Integration of the motion along the legs of a gait.
//!
//! Without inertia the velocity is linear in the rates of the lengths, so a leg is a path and its end depends on the
//! path alone: time only labels it. [`Method::Collocation`] asks the model at a few Gauss points of the leg;
//! where the position does not matter this is Gauss quadrature of a line integral.

mod collocation;
mod euler;
mod gauss;
mod inertia;
mod leg_evaluator;
mod leg_solution;
mod piece;
mod result;
mod rotation;
mod runge_kutta;
mod step_size;

use inertia::Scheme;
use leg_evaluator::LegEvaluator;
use nalgebra::DVector;
use rigid::State;

pub use leg_solution::LegSolution;
pub use piece::PathPiece;
pub use result::LegResult;

use crate::SwimError;
use models::Hydrodynamics;
use scene::{Leg, Scene};

/// How a leg is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Gauss collocation in rotation-vector coordinates about the middle of the step, with as many points as the
    /// tolerance needs: order `2n` with `n` points, and symmetric: the reversed stroke goes back the same way.
    Collocation,
    /// The Runge-Kutta pair of Dormand & Prince on the group of states, steps as long as the tolerance allows: order 5, for comparison.
    RungeKutta,
    /// Explicit Euler with this many steps a leg: first order, for comparison.
    Euler {
        /// Number of equal steps.
        steps: usize,
    },
    /// Backward Euler with the bodies' masses and moments of inertia: first order, stable for steps of any length.
    BackwardEuler {
        /// Number of equal steps.
        steps: usize,
    },
    /// Explicit Euler with masses and moments of inertia, for comparison: refuses steps beyond its limit of stability, twice the
    /// shortest relaxation time.
    ExplicitInertia {
        /// Number of equal steps.
        steps: usize,
    },
}

/// Integrates the motion of a scene's bodies leg by leg.
pub struct Integrator<'a> {
    scene: &'a Scene,
    model: &'a mut dyn Hydrodynamics,
    method: Method,
    /// Velocities of the bodies with surfaces at the end of the last leg, for methods with inertia.
    velocity: Option<DVector<f64>>,
}

impl<'a> Integrator<'a> {
    /// An integrator that asks `model` about `scene`.
    pub fn new(scene: &'a Scene, model: &'a mut dyn Hydrodynamics, method: Method) -> Self {
        Self {
            scene,
            model,
            method,
            velocity: None,
        }
    }

    /// The model that is asked.
    pub fn model(&self) -> &dyn Hydrodynamics {
        self.model
    }

    /// Moves the bodies from `start` along a leg; `observe` sees every solve together with the model that made it.
    ///
    /// # Errors
    /// What the model refuses, bodies that come to touch each other or a wall, a tolerance out of reach, and what
    /// `observe` returns.
    pub fn leg(
        &mut self,
        leg: &Leg,
        start: &State,
        observe: &mut dyn FnMut(&LegSolution, &dyn Hydrodynamics) -> Result<(), SwimError>,
    ) -> Result<LegResult, SwimError> {
        // A leg starts from the history of the model alone, as a resumed run does.
        let history = self.model.history()?;
        self.model.restore(&history)?;
        let mut evaluator = LegEvaluator::new(self.scene, self.model, leg, observe);
        match self.method {
            Method::Collocation => collocation::leg(&mut evaluator, start),
            Method::RungeKutta => runge_kutta::leg(&mut evaluator, start),
            Method::Euler { steps } => euler::leg(&mut evaluator, start, steps.max(1)),
            Method::BackwardEuler { steps } => inertia::leg(
                &mut evaluator,
                start,
                steps.max(1),
                Scheme::Implicit,
                &mut self.velocity,
            ),
            Method::ExplicitInertia { steps } => inertia::leg(
                &mut evaluator,
                start,
                steps.max(1),
                Scheme::Explicit,
                &mut self.velocity,
            ),
        }
    }
}
