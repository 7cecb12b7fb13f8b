//! Integration of the motion along the legs of a gait.
//!
//! Without inertia the velocity is linear in the rates of the lengths, so a leg is a path and its end depends on the
//! path alone: time only labels it. [`Method::Collocation`] asks the model at a few Gauss points of the leg;
//! where the position does not matter this is Gauss quadrature of a line integral.

mod collocation;
mod euler;
mod gauss;
mod oracle;
mod piece;
mod result;
mod rotation;

use oracle::Oracle;
use rigid::State;

pub use piece::PathPiece;
pub use result::{LegResult, Solved};

use crate::SwimError;
use crate::gait::Leg;
use crate::model::Hydrodynamics;
use crate::scene::Scene;

/// How a leg is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Gauss collocation in rotation-vector coordinates about the middle of the step, with as many points as the
    /// tolerance needs: order `2n` with `n` points, and symmetric: the reversed stroke goes back the same way.
    Collocation,
    /// Explicit Euler with this many steps a leg: first order, for comparison.
    Euler {
        /// Number of equal steps.
        steps: usize,
    },
}

/// Integrates the motion of a scene's bodies leg by leg.
pub struct Integrator<'a> {
    scene: &'a Scene,
    model: &'a mut dyn Hydrodynamics,
    method: Method,
}

impl<'a> Integrator<'a> {
    /// An integrator that asks `model` about `scene`.
    pub fn new(scene: &'a Scene, model: &'a mut dyn Hydrodynamics, method: Method) -> Self {
        Self {
            scene,
            model,
            method,
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
        observe: &mut dyn FnMut(&Solved, &dyn Hydrodynamics) -> Result<(), SwimError>,
    ) -> Result<LegResult, SwimError> {
        self.model.begin_leg();
        let mut oracle = Oracle::new(self.scene, self.model, leg, observe);
        match self.method {
            Method::Collocation => collocation::leg(&mut oracle, start),
            Method::Euler { steps } => euler::leg(&mut oracle, start, steps.max(1)),
        }
    }
}
