//! The path over a part of a phase span as a polynomial in coordinates about its middle.

use nalgebra::Vector3;
use rigid::{
    Articulation, DerivativeBounds, MotionBounds, RigidError, State, StateBounds, StateVelocity,
    Twist, ValueBounds,
};
use serde::{Deserialize, Serialize};

use super::inverse_dexp::coordinate_rate;
use crate::error::SwimError;
use crate::gauss::{Gauss, bernstein, lagrange};

/// The path over a part of a phase span: rates of the coordinates at Gauss points, and the state on
/// which the coordinates are centred.
#[derive(Clone, Debug, Deserialize, Serialize)]
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
    /// The piece of a path at the position `s`; none of an empty path.
    pub(crate) fn around(pieces: &[Self], s: f64) -> Option<&Self> {
        let number = pieces.partition_point(|piece| piece.to < s);
        pieces.get(number).or(pieces.last())
    }

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

    /// The path of a step of a Runge-Kutta method: the cubic Hermite interpolant of the coordinates
    /// through the step `sigma`, with the velocities `first` and `last` at its ends.
    ///
    /// With the rates `r_0` and `r_1` of the coordinates about the middle at the ends, the rate at
    /// `t` in [0, 1] is
    ///
    /// ```text
    /// (1 - t) (1 - 3 t) r_0 + t (3 t - 2) r_1 + 6 t (1 - t) sigma
    /// ```
    ///
    /// (Hairer, Nørsett & Wanner 1993, II.6.7). Its error is of order four.
    pub(super) fn hermite(
        set: &Articulation,
        start: &State,
        span: (f64, f64),
        sigma: &StateVelocity,
        [first, last]: [&StateVelocity; 2],
        duration: f64,
    ) -> Result<Self, SwimError> {
        let ends = [(-0.5, first), (0.5, last)];
        let [first, last] = ends
            .map(|(part, velocity)| &coordinate_rate(set, &(sigma * part), velocity) * duration);
        // Three Gauss points determine a rate of degree two.
        let rate = |&t: &f64| {
            let weights = [(1.0 - t) * (1.0 - 3.0 * t), t * (3.0 * t - 2.0)];
            let of_step = (sigma, 6.0 * t * (1.0 - t));
            let of_ends = [&first, &last].into_iter().zip(weights);
            combination(of_ends.chain([of_step]), start)
        };
        let rates = Gauss::new(3).nodes.iter().map(rate).collect();
        Self::new(set, start, span, rates)
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
    pub(crate) fn state(&self, set: &Articulation, s: f64) -> Result<State, RigidError> {
        let t = if self.to > self.from {
            (s - self.from) / (self.to - self.from)
        } else {
            1.0
        };
        set.advance(&self.centre, &self.coordinates(t))
    }

    /// Bounds on the derivatives of the state with respect to `t` in [0, 1], from the bounds
    /// `joints` on the values of all joints that are prescribed.
    ///
    /// With the rates `σ'` of a rotation vector, the angular velocity is `dexp_σ(σ')`. As `dexp_σ =
    /// ∫ exp(u σ) du` over [0, 1], its norm is at most one and that of its derivative in the
    /// direction `σ'` at most `|σ'| / 2`, so that
    ///
    /// ```text
    /// |ω| <= |σ'|,   |ω'| <= |σ''| + |σ'|² / 2
    /// ```
    pub(super) fn bounds(&self, set: &Articulation, joints: Vec<ValueBounds>) -> StateBounds {
        let coefficients = bernstein(&self.nodes);
        let degree = self.nodes.len() - 1;
        let bound = |rate: &dyn Fn(&StateVelocity) -> Vector3<f64>| {
            let rates: Vec<_> = self.rates.iter().map(rate).collect();
            let coefficient = |k: usize| -> Vector3<f64> {
                let terms = rates.iter().zip(&coefficients);
                terms.map(|(rate, of_node)| rate * of_node[k]).sum()
            };
            let all: Vec<_> = (0..=degree).map(coefficient).collect();
            let changes = all.windows(2).map(|pair| (pair[1] - pair[0]).norm());
            DerivativeBounds {
                first: all.iter().map(|x| x.norm()).fold(0.0, f64::max),
                second: degree as f64 * changes.fold(0.0, f64::max),
            }
        };
        let angular = |rate: &dyn Fn(&StateVelocity) -> Vector3<f64>| {
            let DerivativeBounds { first, second } = bound(rate);
            DerivativeBounds {
                first,
                second: second + 0.5 * first * first,
            }
        };
        let frames = (0..self.centre.frames.len()).map(|frame| MotionBounds {
            linear: bound(&|rate| rate.frames[frame].linear),
            angular: angular(&|rate| rate.frames[frame].angular),
        });
        let attitude = |body: usize| match set.has_own_attitude(body) {
            true => angular(&|rate| rate.spins[body]),
            false => DerivativeBounds::default(),
        };
        let mut joints = joints;
        for (number, (joint, _)) in set.passive_drives().enumerate() {
            let derivatives = bound(&|rate| Vector3::new(rate.joints[number], 0.0, 0.0));
            // The coordinate is at most its largest rate away from the centre.
            joints[joint] = ValueBounds {
                size: self.centre.joints[number].abs() + derivatives.first,
                derivatives,
            };
        }
        StateBounds {
            frames: frames.collect(),
            attitudes: (0..self.centre.attitudes.len()).map(attitude).collect(),
            joints,
        }
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
