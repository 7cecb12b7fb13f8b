//! What became of a leg, put together from its parts.

use rigid::{Articulation, State};

use super::oracle::Oracle;
use super::piece::PathPiece;
use crate::SwimError;
use crate::model::{BodyInstant, Drift, ErrorEstimate, Instant, Seconds};

/// One rung of the ladder, or one step: a path, the answers that made it, and the weights by which they stand for its duration.
pub(super) struct Rung {
    pub piece: PathPiece,
    pub solved: Vec<Solved>,
    pub weights: Vec<f64>,
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
    /// What the mesh's errors add up to; none where some part of the leg was not estimated.
    pub drift: Option<Drift>,
    /// What the integration's errors add up to, for methods that know them with their signs; others enter
    /// [`ErrorEstimate::integration`] here.
    pub integration_drift: Option<Drift>,
    /// Whether the integration met its share of the tolerance.
    pub tolerance_met: bool,
    /// Work of the bodies on the fluid.
    pub work: f64,
    /// Seconds of all solves.
    pub seconds: Seconds,
}

impl Rung {
    /// What the mesh's errors add up to over `duration`, by the rung's own points; none if they were not estimated.
    pub fn drift(&self, duration: f64) -> Option<Drift> {
        let mut drift = Drift::default();
        for (solved, weight) in self.solved.iter().zip(&self.weights) {
            let error = solved.instant.mesh_error.as_ref()?;
            drift.add(weight * duration, &solved.instant.motion, error);
        }
        Some(drift)
    }
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

    pub(super) fn at(start: &State) -> Self {
        Self {
            end: start.clone(),
            solved: Vec::new(),
            pieces: Vec::new(),
            solves: 0,
            error_estimate: ErrorEstimate::default(),
            drift: Some(Drift::default()),
            integration_drift: None,
            tolerance_met: true,
            work: 0.0,
            seconds: Seconds::default(),
        }
    }

    /// Appends an accepted rung: its path, its answers and what they add up to.
    pub(super) fn append(
        &mut self,
        oracle: &Oracle,
        rung: Rung,
        error: Option<f64>,
        drift: Option<&Drift>,
    ) -> Result<(), SwimError> {
        let Rung {
            piece,
            solved,
            weights,
        } = rung;
        let moved: Vec<_> = piece.step().frames.iter().map(|f| f.linear).collect();
        self.drift = match (self.drift.take(), drift) {
            (Some(mut sum), Some(part)) => {
                sum.append(part, &moved);
                Some(sum)
            }
            _ => None,
        };
        let duration = oracle.leg.duration * (piece.to - piece.from);
        let power = |b: &BodyInstant| b.force.dot(&b.velocity) + b.torque.dot(&b.angular_velocity);
        for (solved, weight) in solved.iter().zip(weights) {
            let instant = &solved.instant;
            // Errors by the mesh are added up with their signs, in the drift.
            let without_mesh = ErrorEstimate {
                mesh: None,
                ..instant.error_estimate
            };
            self.error_estimate
                .accumulate(weight * duration, &without_mesh);
            self.work += weight * duration * instant.bodies.iter().map(power).sum::<f64>();
        }
        let integration = ErrorEstimate {
            integration: error,
            ..ErrorEstimate::default()
        };
        self.error_estimate.accumulate(1.0, &integration);
        self.end = piece.state(&oracle.scene.articulation, piece.to)?;
        self.solved.extend(solved);
        self.pieces.push(piece);
        Ok(())
    }

    /// Enters what the oracle counted.
    pub(super) fn closed(self, oracle: &Oracle) -> Self {
        Self {
            solves: oracle.solves,
            seconds: oracle.seconds,
            ..self
        }
    }
}
