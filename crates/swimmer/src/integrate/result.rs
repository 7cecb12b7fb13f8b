//! What became of a leg, put together from its parts.

use rigid::{Articulation, State};

use super::leg_evaluator::LegEvaluator;
use super::leg_solution::LegSolution;
use super::piece::PathPiece;
use crate::SwimError;
use models::{AccumulatedError, BodySolution, ErrorEstimate, Seconds};

/// One rung of the ladder, or one step: a path, the answers that made it, and the weights by which they stand for its duration.
pub(super) struct Rung {
    pub piece: PathPiece,
    pub solved: Vec<LegSolution>,
    pub weights: Vec<f64>,
}

/// What became of a leg.
#[derive(Clone, Debug)]
pub struct LegResult {
    /// The state at the end.
    pub end: State,
    /// The solves whose answers the result is made of, in the order of `s`.
    pub solved: Vec<LegSolution>,
    /// The path as polynomials, in order.
    pub pieces: Vec<PathPiece>,
    /// All solves made, the discarded ones included.
    pub solves: usize,
    /// Error bars of the displacement.
    pub error_estimate: ErrorEstimate,
    /// What the mesh's errors add up to; none where some part of the leg was not estimated.
    pub accumulated_error: Option<AccumulatedError>,
    /// What the integration's errors add up to, for methods that know them with their signs; others enter
    /// [`ErrorEstimate::integration`] here.
    pub accumulated_integration_error: Option<AccumulatedError>,
    /// Whether the integration met its share of the tolerance.
    pub tolerance_met: bool,
    /// Work of the bodies on the fluid.
    pub work: f64,
    /// Seconds of all solves.
    pub seconds: Seconds,
}

impl Rung {
    /// What the mesh's errors add up to over `duration`, by the rung's own points; none if they were not estimated.
    pub fn accumulated_error(&self, duration: f64) -> Option<AccumulatedError> {
        let mut accumulated = AccumulatedError::default();
        for (solved, weight) in self.solved.iter().zip(&self.weights) {
            let error = solved.solution.mesh_error.as_ref()?;
            accumulated.add(weight * duration, &solved.solution.motion, error);
        }
        Some(accumulated)
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
            accumulated_error: Some(AccumulatedError::default()),
            accumulated_integration_error: None,
            tolerance_met: true,
            work: 0.0,
            seconds: Seconds::default(),
        }
    }

    /// Appends an accepted rung: its path, its answers and what they add up to.
    pub(super) fn append(
        &mut self,
        evaluator: &LegEvaluator,
        rung: Rung,
        error: Option<f64>,
        accumulated: Option<&AccumulatedError>,
    ) -> Result<(), SwimError> {
        let Rung {
            piece,
            solved,
            weights,
        } = rung;
        let moved: Vec<_> = piece.step().frames.iter().map(|f| f.linear).collect();
        self.accumulated_error = match (self.accumulated_error.take(), accumulated) {
            (Some(mut sum), Some(part)) => {
                sum.append(part, &moved);
                Some(sum)
            }
            _ => None,
        };
        let duration = evaluator.leg.duration * (piece.to - piece.from);
        let power = |b: &BodySolution| b.force.dot(&b.velocity) + b.torque.dot(&b.angular_velocity);
        for (solved, weight) in solved.iter().zip(weights) {
            let instant = &solved.solution;
            // Errors by the mesh are added up with their signs, in the accumulated.
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
        self.end = piece.state(evaluator.scene.articulation(), piece.to)?;
        self.solved.extend(solved);
        self.pieces.push(piece);
        Ok(())
    }

    /// Enters what the evaluator counted.
    pub(super) fn closed(self, evaluator: &LegEvaluator) -> Self {
        Self {
            solves: evaluator.solves,
            seconds: evaluator.seconds,
            ..self
        }
    }
}
