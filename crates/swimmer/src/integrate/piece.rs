//! The path over a part of a phase span as a polynomial in coordinates about its middle.

use nalgebra::Vector3;
use rigid::{Articulation, State, StateVelocity, Twist};

use crate::error::SwimError;
use crate::gauss::{Gauss, lagrange};

/// The path over a part of a phase span: rates of the coordinates at Gauss points, and the state on
/// which the coordinates are centred.
#[derive(Clone, Debug)]
pub struct PathPiece {
    /// Start of the part, as a position `s` in [0, 1] on the phase span.
    pub from: f64,
    /// End of the part.
    pub to: f64,
    centre: State,
    half: StateVelocity,
    nodes: Vec<f64>,
    rates: Vec<StateVelocity>,
}

impl PathPiece {
    /// The path that starts at the state `start` and has these rates at the Gauss points of `span`.
    pub(super) fn new(
        set: &Articulation,
        start: &State,
        span: (f64, f64),
        rates: Vec<StateVelocity>,
    ) -> Result<Self, SwimError> {
        let gauss = Gauss::new(rates.len());
        let half = combination(
            rates.iter().zip(gauss.weights.iter().map(|w| 0.5 * w)),
            start,
        );
        let centre = set.advance(start, &half)?;
        Ok(Self {
            from: span.0,
            to: span.1,
            centre,
            half,
            nodes: gauss.nodes,
            rates,
        })
    }

    /// The path whose rates are the polynomial through `rates` at the `nodes` in [0, 1].
    pub(super) fn through(
        set: &Articulation,
        start: &State,
        span: (f64, f64),
        nodes: &[f64],
        rates: &[StateVelocity],
    ) -> Result<Self, SwimError> {
        let at = |t: f64| {
            let rates = rates.iter().enumerate();
            let terms = rates.map(|(i, rate)| (rate, lagrange(nodes, i, t)));
            combination(terms, start)
        };
        let gauss = Gauss::new(nodes.len());
        Self::new(
            set,
            start,
            span,
            gauss.nodes.iter().map(|&t| at(t)).collect(),
        )
    }

    /// Coordinates about the centre at `t` in [0, 1].
    pub(super) fn coordinates(&self, t: f64) -> StateVelocity {
        let integrals = Gauss::new(self.nodes.len()).integrals(&self.nodes, t);
        &combination(self.rates.iter().zip(integrals), &self.centre) + &(&self.half * -1.0)
    }

    /// The state at the position `s` on the phase span.
    pub(super) fn state(&self, set: &Articulation, s: f64) -> Result<State, SwimError> {
        let t = if self.to > self.from {
            (s - self.from) / (self.to - self.from)
        } else {
            1.0
        };
        Ok(set.advance(&self.centre, &self.coordinates(t))?)
    }

    /// The whole step in coordinates about the centre.
    pub(super) fn step(&self) -> StateVelocity {
        &self.half * 2.0
    }
}

/// The weighted sum of velocities, zero for an empty list, with as many frames as `state`.
pub(super) fn combination<'a>(
    terms: impl Iterator<Item = (&'a StateVelocity, f64)>,
    state: &State,
) -> StateVelocity {
    let zero = StateVelocity {
        frames: vec![Twist::default(); state.frames.len()],
        spins: vec![Vector3::zeros(); state.attitudes.len()],
        joints: vec![0.0; state.joints.len()],
    };
    terms.fold(zero, |sum, (rate, weight)| &sum + &(rate * weight))
}
