//! The result of a leg, put together from its parts.

use models::{AccumulatedError, ErrorEstimate, InstantaneousSolution, MeshError, Seconds};
use rigid::{Articulation, State, StateVelocity};

use super::leg_evaluator::LegEvaluator;
use super::leg_solution::LegSolution;
use super::piece::PathPiece;
use crate::error::SwimError;

/// An approximation of the motion over a part of a leg: one collocation order, or one step.
pub(super) struct Approximation {
    /// The path.
    pub piece: PathPiece,
    /// The solutions from which the path was computed.
    pub solutions: Vec<LegSolution>,
    /// Quadrature weights of the solutions; their sum is one.
    pub weights: Vec<f64>,
}

/// Estimated integration errors of a part of a leg.
#[derive(Clone, Copy, Debug)]
pub(super) struct IntegrationError {
    /// Error of the displacement.
    pub displacement: f64,
    /// Error of the work of the bodies on the fluid.
    pub work: f64,
}

/// The result of integrating the motion over a leg.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LegResult {
    /// The state at the end.
    pub end: State,
    /// The solutions from which the path was computed, in the order of `s`.
    pub solutions: Vec<LegSolution>,
    /// The path as polynomials, in order.
    pub pieces: Vec<PathPiece>,
    /// Number of solves, including the discarded ones.
    pub solves: usize,
    /// Error bars of the displacement.
    pub error_estimate: ErrorEstimate,
    /// Accumulated discretisation error that was subtracted, and its uncertainty; none where a part
    /// of the leg has no estimate.
    pub accumulated_error: Option<AccumulatedError>,
    /// Accumulated error of the integration, for methods that estimate it with its sign; other
    /// methods enter its size in [`ErrorEstimate::integration`].
    pub accumulated_integration_error: Option<AccumulatedError>,
    /// Work of the bodies on the fluid.
    pub work: f64,
    /// Error bars of the work.
    pub work_error: ErrorEstimate,
    /// Seconds of all solves.
    pub seconds: Seconds,
    /// Velocities `(U, ω)` of all bodies at the end, for methods with inertia; empty for others.
    pub velocities: Vec<f64>,
}

impl Approximation {
    /// The estimated discretisation error that was subtracted over `duration`, by quadrature over
    /// the solutions; none if one of them has no estimate.
    pub fn accumulated_error(&self, duration: f64) -> Option<AccumulatedError> {
        let mut accumulated = AccumulatedError::default();
        for (solution, weight) in self.solutions.iter().zip(&self.weights) {
            solution.solution.mesh_error.as_ref()?;
            accumulated.add(weight * duration, &solution.solution);
        }
        Some(accumulated)
    }

    /// The step without the corrections of the solutions.
    pub fn uncorrected_step(&self, duration: f64) -> StateVelocity {
        let solutions = self.solutions.iter().zip(&self.weights);
        solutions.fold(
            self.piece.step(),
            |step, (solution, weight)| match &solution.solution.mesh_error {
                Some(error) => &step + &(&error.motion * (weight * duration)),
                None => step,
            },
        )
    }

    /// Error bar of the displacement over `duration` by all errors of the solutions.
    pub fn error_bar(&self, duration: f64) -> f64 {
        self.integral(duration, |solution| solution.error_estimate.total())
    }

    /// Error bar of the displacement over `duration` by the discretisation without corrections;
    /// zero without estimates.
    pub fn uncorrected_mesh_error_bar(&self, duration: f64) -> f64 {
        self.integral(duration, |solution| {
            let removed = solution
                .mesh_error
                .as_ref()
                .map_or(0.0, MeshError::velocity);
            removed + solution.error_estimate.mesh.unwrap_or(0.0)
        })
    }

    /// Work of the bodies on the fluid over `duration`.
    pub fn work(&self, duration: f64) -> f64 {
        self.integral(duration, InstantaneousSolution::power)
    }

    /// Work without the corrections of the solutions.
    pub fn uncorrected_work(&self, duration: f64) -> f64 {
        self.integral(duration, InstantaneousSolution::uncorrected_power)
    }

    fn integral(&self, duration: f64, of: impl Fn(&InstantaneousSolution) -> f64) -> f64 {
        let values = self.solutions.iter().map(|s| of(&s.solution));
        let terms = values.zip(&self.weights).map(|(value, w)| w * value);
        duration * terms.sum::<f64>()
    }
}

impl LegResult {
    /// The state at the position `s` in [0, 1] on the leg.
    ///
    /// # Errors
    /// None for the articulation that was integrated; for another one, those of
    /// [`Articulation::advance`].
    pub fn state(&self, set: &Articulation, s: f64) -> Result<State, SwimError> {
        let contains = |piece: &&PathPiece| s <= piece.to;
        match self.pieces.iter().find(contains).or(self.pieces.last()) {
            Some(piece) => piece.state(set, s),
            None => Ok(self.end.clone()),
        }
    }

    /// The result before the first step.
    pub(super) fn empty(start: &State) -> Self {
        Self {
            end: start.clone(),
            solutions: Vec::new(),
            pieces: Vec::new(),
            solves: 0,
            error_estimate: ErrorEstimate::default(),
            accumulated_error: Some(AccumulatedError::default()),
            accumulated_integration_error: None,
            work: 0.0,
            work_error: ErrorEstimate::default(),
            seconds: Seconds::default(),
            velocities: Vec::new(),
        }
    }

    /// Appends an accepted approximation of the next part of the leg.
    ///
    /// `integration_error` are its estimated integration errors, `accumulated` its accumulated
    /// discretisation error; each is none where the method has no estimate.
    pub(super) fn append(
        &mut self,
        evaluator: &LegEvaluator,
        approximation: Approximation,
        integration_error: Option<IntegrationError>,
        accumulated: Option<&AccumulatedError>,
    ) -> Result<(), SwimError> {
        let duration = evaluator.leg.duration * (approximation.piece.to - approximation.piece.from);
        self.work += approximation.work(duration);
        let Approximation {
            piece,
            solutions,
            weights,
        } = approximation;
        let displacement: Vec<_> = piece.step().frames.iter().map(|f| f.linear).collect();
        self.accumulated_error = match (self.accumulated_error.take(), accumulated) {
            (Some(mut sum), Some(part)) => {
                sum.append(part, &displacement);
                Some(sum)
            }
            _ => None,
        };
        // Bars of the discretisation are in `accumulated_error`.
        let without_mesh = |bars: &ErrorEstimate| ErrorEstimate {
            mesh: None,
            ..*bars
        };
        for (leg_solution, weight) in solutions.iter().zip(weights) {
            let solution = &leg_solution.solution;
            let time = weight * duration;
            (self.error_estimate).accumulate(time, &without_mesh(&solution.error_estimate));
            (self.work_error).accumulate(time, &without_mesh(&solution.power_error));
        }
        let integration = |error: Option<f64>| ErrorEstimate {
            integration: error,
            ..ErrorEstimate::default()
        };
        let of_displacement = integration_error.map(|error| error.displacement);
        let of_work = integration_error.map(|error| error.work);
        self.error_estimate
            .accumulate(1.0, &integration(of_displacement));
        self.work_error.accumulate(1.0, &integration(of_work));
        let set = evaluator.scene.articulation();
        let end = piece.state(set, piece.to)?;
        self.end = set.closed(&end, &evaluator.leg.lengths(piece.to))?;
        self.solutions.extend(solutions);
        self.pieces.push(piece);
        Ok(())
    }

    /// The result with the number and the time of all solves of the evaluator.
    pub(super) fn with_totals(self, evaluator: &LegEvaluator) -> Self {
        Self {
            solves: evaluator.solves,
            seconds: evaluator.seconds,
            ..self
        }
    }
}
