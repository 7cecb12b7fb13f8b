//! Integration of the motion along the legs of a gait.
//!
//! Without inertia the velocity is linear in the rates of the lengths, so a leg is a path and its end depends on the
//! path alone: time only labels it. [`Method::Collocation`] asks the model at a few Gauss points of the leg;
//! where the position does not matter this is Gauss quadrature of a line integral.

mod collocation;
mod gauss;
mod oracle;
mod rotation;

use rigid::{Articulation, State};

use crate::gait::Leg;
use crate::model::{ErrorEstimate, Hydrodynamics, Instant, Seconds};
use crate::scene::Scene;
use crate::SwimError;
pub use collocation::PathPiece;
use oracle::Oracle;

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

/// The model's answer at a point of a leg.
#[derive(Clone, Debug)]
pub struct Solved {
    /// Number of the solve from zero, over the whole simulation.
    pub number: usize,
    /// Where on the leg.
    pub s: f64,
    /// The state it was asked for.
    pub state: State,
    /// The answer.
    pub instant: Instant,
}

/// What became of a leg.
#[derive(Clone, Debug)]
pub struct LegResult {
    /// The state at the end.
    pub end: State,
    /// The solves whose answers the result is made of, in the order of `s`.
    pub solved: Vec<Solved>,
    /// The path as polynomials, in order.
    pub pieces: Vec<PathPiece>,
    /// All solves made, the discarded ones included.
    pub solves: usize,
    /// Error bars of the displacement.
    pub error_estimate: ErrorEstimate,
    /// Whether the integration met its share of the tolerance.
    pub tolerance_met: bool,
    /// Work of the bodies on the fluid.
    pub work: f64,
    /// Seconds of all solves.
    pub seconds: Seconds,
}

impl LegResult {
    /// The state at a point of the leg.
    ///
    /// # Errors
    /// None for results of an integrator; the set's own checks otherwise.
    pub fn state(&self, set: &Articulation, s: f64) -> Result<State, SwimError> {
        let within = |piece: &&PathPiece| s <= piece.to;
        match self.pieces.iter().find(within).or(self.pieces.last()) {
            Some(piece) => piece.state(set, s),
            None => Ok(self.end.clone()),
        }
    }
}

impl<'a> Integrator<'a> {
    /// An integrator that asks `model` about `scene`.
    pub fn new(scene: &'a Scene, model: &'a mut dyn Hydrodynamics, method: Method) -> Self {
        Self { scene, model, method }
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
        let mut oracle = Oracle::new(self.scene, self.model, leg, observe);
        match self.method {
            Method::Collocation => collocation::leg(&mut oracle, start),
            Method::Euler { steps } => collocation::euler(&mut oracle, start, steps.max(1)),
        }
    }
}
