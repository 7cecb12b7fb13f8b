//! The result of a phase span, put together from its parts.

use std::ops::AddAssign;

use models::{
    AccumulatedError, BodySolution, DiscretisationError, ErrorEstimate, InstantaneousSolution,
    Seconds,
};
use nalgebra::Vector3;
use rigid::{Articulation, State, StateVelocity};
use scene::Scene;

use super::masses::{Velocities, numbers_of};
use super::moving_fluid::UnsteadyState;
use super::piece::PathPiece;
use super::span_evaluator::{SpanEvaluator, SpanSolution};
use crate::error::SwimError;
use crate::gauss::lagrange;
use crate::holding_loads::HoldingLoads;
use crate::linkage_works::{LinkageWork, add_each, has_linkage_works, linkage_powers};
use crate::mean_flow::MeanFlowInTime;

/// An approximation of the motion over a part of a phase span: one collocation order, or one step.
pub(super) struct Approximation {
    /// The path.
    pub piece: PathPiece,
    /// The solutions from which the path was computed.
    pub solutions: Vec<SpanSolution>,
    /// Quadrature weights of the solutions; their sum is one.
    pub weights: Vec<f64>,
    /// Estimated integration errors of works of linkages and of the mean flow; none where the
    /// method has no estimate.
    pub integral_errors: Option<IntegralErrors>,
}

/// What is integrated beside the motion: works of linkages and the mean flow.
#[derive(Default)]
pub(super) struct Integrals {
    works: Vec<f64>,
    mean_flow: Option<MeanFlowInTime>,
}

/// Sizes of errors of [`Integrals`], or of changes of them.
#[derive(Clone, Debug, Default)]
pub(super) struct IntegralErrors {
    /// Of the work of each linkage; empty where works are known in total only.
    pub works: Vec<f64>,
    /// Of the mean flow of a periodic box, or of its pressure gradient if the flow is given.
    pub mean_flow: f64,
}

impl Integrals {
    /// The integrals of solutions, each with the time for which it stands.
    pub fn new<'a>(
        scene: &Scene,
        solutions: impl Iterator<Item = (&'a InstantaneousSolution, f64)> + Clone,
    ) -> Self {
        let mut works = Vec::new();
        if has_linkage_works(scene) {
            for (solution, time) in solutions.clone() {
                let powers = linkage_powers(scene.articulation(), solution).into_iter();
                add_each(&mut works, &powers.map(|p| p * time).collect::<Vec<_>>());
            }
        }
        Self {
            works,
            mean_flow: MeanFlowInTime::integrals(solutions),
        }
    }

    /// Sizes of the changes from other integrals, of which none are zero.
    pub fn change_from(&self, other: &Self, scene: &Scene) -> IntegralErrors {
        let others = other.works.iter().copied().chain(std::iter::repeat(0.0));
        let none = MeanFlowInTime::default();
        let change = |flow: &MeanFlowInTime| {
            flow.difference(other.mean_flow.as_ref().unwrap_or(&none), scene)
        };
        IntegralErrors {
            works: (self.works.iter().zip(others))
                .map(|(a, b)| (a - b).abs())
                .collect(),
            mean_flow: self.mean_flow.as_ref().map_or(0.0, change),
        }
    }
}

/// Estimated sizes of the integration errors of a part of a phase span.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct IntegrationError {
    /// Error of the displacement.
    pub displacement: f64,
    /// Error of the rotation of a body, in radians.
    pub rotation: f64,
    /// Error of the work of the bodies on the fluid.
    pub work: f64,
    /// Errors of the impulses of the forces and of the torques that hold bodies.
    pub holding: [f64; 2],
}

impl IntegrationError {
    /// The errors as an accumulated error without a sign.
    pub fn unsigned(&self) -> AccumulatedError {
        AccumulatedError {
            uncertainty: self.displacement,
            rotation_uncertainty: self.rotation,
            work_uncertainty: self.work,
            holding_uncertainty: self.holding,
            ..AccumulatedError::default()
        }
    }
}

impl AddAssign for IntegrationError {
    fn add_assign(&mut self, other: Self) {
        self.displacement += other.displacement;
        self.rotation += other.rotation;
        self.work += other.work;
        (self.holding.iter_mut().zip(other.holding)).for_each(|(sum, error)| *sum += error);
    }
}

/// The result of integrating the motion over a phase span.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct SpanResult {
    /// The state at the end.
    pub end: State,
    /// The solutions from which the path was computed, in the order of `s`.
    pub solutions: Vec<SpanSolution>,
    /// The path as polynomials, in order.
    pub pieces: Vec<PathPiece>,
    /// Number of solutions, including the discarded ones.
    pub solves: usize,
    /// Number of these that were looked up in tables over shapes.
    pub lookups: usize,
    /// Number of solves that each of these tables is made of.
    pub tables: Vec<usize>,
    /// Error bars of the displacement.
    pub error_estimate: ErrorEstimate,
    /// Error bars of the rotation of the bodies, in radians.
    pub rotation_error: ErrorEstimate,
    /// Accumulated discretisation error that was subtracted, and its uncertainty; none where a part
    /// of the phase span has no estimate.
    pub accumulated_error: Option<AccumulatedError>,
    /// Accumulated error by the model; without a sign where solutions have none.
    pub accumulated_model_error: AccumulatedError,
    /// Accumulated error of the integration; without a sign, as uncertainty alone, for methods that
    /// estimate its size. None where a part of the phase span has no estimate.
    pub accumulated_integration_error: Option<AccumulatedError>,
    /// Work of the bodies on the fluid.
    pub work: f64,
    /// Work of the bodies of each linkage on the fluid; empty where it is known in total only.
    pub linkage_works: Vec<LinkageWork>,
    /// Error bars of the work.
    pub work_error: ErrorEstimate,
    /// Impulses of the loads that hold or drive bodies.
    pub holding: HoldingLoads,
    /// Integral of the mean flow; none outside of periodic boxes.
    pub mean_flow: Option<MeanFlowInTime>,
    /// Seconds of all solves.
    pub seconds: Seconds,
    /// Velocities `(U, ω)` of all bodies at the end, for methods with inertia; empty for others.
    pub velocities: Vec<f64>,
    /// The fluid at the end if it has inertia; none for a part of a phase span.
    pub fluid: Option<UnsteadyState>,
}

/// An error that ends the integration of a phase span.
pub(super) struct Stopped {
    pub error: Box<SwimError>,
    /// The part of the phase span before the error, if the motion up to there is a result.
    pub so_far: Option<Box<SpanResult>>,
}

impl<E: Into<SwimError>> From<E> for Stopped {
    fn from(error: E) -> Self {
        Self {
            error: Box::new(error.into()),
            so_far: None,
        }
    }
}

impl Approximation {
    /// An approximation whose integrals have no estimated errors.
    pub fn new(piece: PathPiece, solutions: Vec<SpanSolution>, weights: Vec<f64>) -> Self {
        Self {
            piece,
            solutions,
            weights,
            integral_errors: None,
        }
    }

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

    /// Error bar of the displacement over `duration` that tables leave, if all solutions were
    /// looked up; zero otherwise.
    ///
    /// It is without the errors of the mesh, which have signs and cancel over a stroke.
    pub fn table_error_bar(&self, duration: f64) -> f64 {
        match self.solutions.iter().all(|s| s.solution.lookup.is_some()) {
            true => self.integral(duration, |solution| {
                let bars = &solution.error_estimate;
                bars.total() - bars.mesh.unwrap_or(0.0)
            }),
            false => 0.0,
        }
    }

    /// Error bar of the displacement over `duration` by the discretisation without corrections;
    /// zero without estimates.
    pub fn uncorrected_mesh_error_bar(&self, duration: f64) -> f64 {
        self.integral(duration, |solution| {
            let removed = solution
                .mesh_error
                .as_ref()
                .map_or(0.0, DiscretisationError::velocity);
            removed + solution.error_estimate.mesh.unwrap_or(0.0)
        })
    }

    /// Work of the bodies on the fluid over `duration`.
    pub fn work(&self, duration: f64) -> f64 {
        self.integral(duration, |solution| solution.power())
    }

    /// Work without the corrections of the solutions.
    pub fn uncorrected_work(&self, duration: f64) -> f64 {
        self.integral(duration, InstantaneousSolution::uncorrected_power)
    }

    /// Angle `∫ |ω| dt` through which a body turns over `duration`, with whole turns.
    pub fn turning_angle(&self, body: usize, duration: f64) -> f64 {
        self.integral(duration, |solution| {
            (solution.bodies.get(body)).map_or(0.0, |body| body.angular_velocity.norm())
        })
    }

    /// Impulses of the loads that hold or drive bodies.
    pub fn holding(&self, duration: f64) -> HoldingLoads {
        HoldingLoads::impulses(self.with_times(duration))
    }

    /// These impulses without the corrections of the solutions.
    pub fn uncorrected_holding(&self, duration: f64) -> HoldingLoads {
        let uncorrected: Vec<_> = (self.with_times(duration))
            .map(|(solution, time)| (solution.uncorrected(), time))
            .collect();
        HoldingLoads::impulses(uncorrected.iter().map(|(solution, time)| (solution, *time)))
    }

    /// Integral of the mean flow through a periodic box.
    pub fn mean_flow(&self, duration: f64) -> Option<MeanFlowInTime> {
        MeanFlowInTime::integrals(self.with_times(duration))
    }

    /// Works of linkages and the mean flow, without the corrections of the solutions.
    pub fn uncorrected_integrals(&self, scene: &Scene, duration: f64) -> Integrals {
        let uncorrected: Vec<_> = (self.with_times(duration))
            .map(|(solution, time)| (solution.uncorrected(), time))
            .collect();
        Integrals::new(
            scene,
            uncorrected.iter().map(|(solution, time)| (solution, *time)),
        )
    }

    /// The solutions, each with the part of `duration` for which it stands.
    fn with_times(
        &self,
        duration: f64,
    ) -> impl Iterator<Item = (&InstantaneousSolution, f64)> + Clone {
        let solutions = self.solutions.iter().map(|s| &s.solution);
        solutions.zip(self.weights.iter().map(move |w| w * duration))
    }

    fn integral(&self, duration: f64, of: impl Fn(&InstantaneousSolution) -> f64) -> f64 {
        let values = self.solutions.iter().map(|s| of(&s.solution));
        let terms = values.zip(&self.weights).map(|(value, w)| w * value);
        duration * terms.sum::<f64>()
    }
}

/// Discretisation error of a part of a phase span.
#[derive(Clone, Copy)]
pub(super) enum Accumulated<'a> {
    /// Its uncertainty is independent of that of the parts before, as on different meshes.
    Independent(&'a AccumulatedError),
    /// It is of the same sign, as on meshes that move through all parts.
    Correlated(&'a AccumulatedError),
}

impl SpanResult {
    /// The state at the position `s` in [0, 1] on the phase span.
    ///
    /// # Errors
    /// None for the articulation that was integrated; for another one, those of
    /// [`Articulation::advance`].
    pub fn state(&self, set: &Articulation, s: f64) -> Result<State, SwimError> {
        match PathPiece::around(&self.pieces, s) {
            Some(piece) => Ok(piece.state(set, s)?),
            None => Ok(self.end.clone()),
        }
    }

    /// Velocities and forces of the bodies at the position `s`, by the polynomial through the
    /// solutions of its step, and through those beside them if they are at its ends; none without
    /// solutions.
    pub fn bodies(&self, s: f64) -> Option<Vec<BodySolution>> {
        let piece = PathPiece::around(&self.pieces, s)?;
        let is_of_step = |of: &&SpanSolution| (piece.from..=piece.to).contains(&of.s);
        let mut of_step: Vec<_> = self.solutions.iter().filter(is_of_step).collect();
        if let [first, last] = of_step[..]
            && (first.s, last.s) == (piece.from, piece.to)
        {
            let before = self.solutions.iter().rfind(|of| of.s < piece.from);
            let after = self.solutions.iter().find(|of| of.s > piece.to);
            of_step.extend(before.into_iter().chain(after));
        }
        // Steps share the solution between them, and stages may be at the same time.
        of_step.sort_by(|a, b| a.s.total_cmp(&b.s));
        of_step.dedup_by(|later, earlier| later.s == earlier.s);
        let nodes: Vec<f64> = of_step.iter().map(|solution| solution.s).collect();
        let weights: Vec<f64> = (0..nodes.len()).map(|i| lagrange(&nodes, i, s)).collect();
        let mut bodies = of_step.first()?.solution.bodies.clone();
        for (body, sum) in bodies.iter_mut().enumerate() {
            let weighted = |of: fn(&BodySolution) -> Vector3<f64>| -> Vector3<f64> {
                let values = of_step
                    .iter()
                    .map(|of_node| of(&of_node.solution.bodies[body]));
                values.zip(&weights).map(|(x, weight)| *weight * x).sum()
            };
            sum.velocity = weighted(|body| body.velocity);
            sum.angular_velocity = weighted(|body| body.angular_velocity);
            sum.force = weighted(|body| body.force);
            sum.torque = weighted(|body| body.torque);
        }
        Some(bodies)
    }

    /// The result before the first step.
    pub(super) fn empty(start: &State) -> Self {
        Self {
            end: start.clone(),
            solutions: Vec::new(),
            pieces: Vec::new(),
            solves: 0,
            lookups: 0,
            tables: Vec::new(),
            error_estimate: ErrorEstimate::default(),
            rotation_error: ErrorEstimate::default(),
            accumulated_error: Some(AccumulatedError::default()),
            accumulated_model_error: AccumulatedError::default(),
            accumulated_integration_error: Some(AccumulatedError::default()),
            work: 0.0,
            linkage_works: Vec::new(),
            work_error: ErrorEstimate::default(),
            holding: HoldingLoads::default(),
            mean_flow: None,
            seconds: Seconds::default(),
            velocities: Vec::new(),
            fluid: None,
        }
    }

    /// The same result with these velocities of the bodies at its end.
    pub(super) fn with_velocities(self, velocities: &Velocities) -> Self {
        Self {
            velocities: numbers_of(velocities),
            ..self
        }
    }

    /// Appends an accepted approximation of the next part of the phase span.
    ///
    /// `integration_error` is its estimated integration error, `accumulated` its accumulated
    /// discretisation error; each is none where the method has no estimate.
    pub(super) fn append(
        &mut self,
        evaluator: &SpanEvaluator,
        approximation: Approximation,
        integration_error: Option<AccumulatedError>,
        accumulated: Option<Accumulated>,
    ) -> Result<(), SwimError> {
        let duration =
            evaluator.span.duration * (approximation.piece.to - approximation.piece.from);
        self.work += approximation.work(duration);
        // Errors do not cancel where an explicit method has a negative weight.
        let weights = &approximation.weights;
        let all: f64 = match weights.iter().any(|weight| *weight < 0.0) {
            true => weights.iter().map(|weight| weight.abs()).sum(),
            false => 1.0,
        };
        if has_linkage_works(evaluator.scene) {
            let set = evaluator.scene.articulation();
            for (solution, time) in approximation.with_times(duration) {
                let of_solution = LinkageWork::of_solution(set, solution, time, time.abs() / all);
                LinkageWork::add_each(&mut self.linkage_works, &of_solution);
            }
        }
        let mut mean_flow = approximation.mean_flow(duration);
        if let Some(errors) = &approximation.integral_errors {
            for (linkage, error) in self.linkage_works.iter_mut().zip(&errors.works) {
                linkage.integration += error;
            }
            if let Some(flow) = &mut mean_flow {
                flow.error.integration = Some(errors.mean_flow);
            }
        }
        MeanFlowInTime::append(&mut self.mean_flow, mean_flow.as_ref());
        self.holding
            .accumulate(1.0, &approximation.holding(duration));
        let Approximation {
            piece,
            solutions,
            weights,
            ..
        } = approximation;
        let displacement: Vec<_> = piece.step().frames.iter().map(|f| f.linear).collect();
        self.accumulated_error = match (self.accumulated_error.take(), accumulated) {
            (Some(mut sum), Some(Accumulated::Independent(part))) => {
                sum.append(part, &displacement);
                Some(sum)
            }
            (Some(mut sum), Some(Accumulated::Correlated(part))) => {
                sum.append_correlated(part, &displacement);
                Some(sum)
            }
            _ => None,
        };
        // Bars of the discretisation are in `accumulated_error`.
        let without_mesh = |bars: &ErrorEstimate| ErrorEstimate {
            mesh: None,
            ..*bars
        };
        for (span_solution, weight) in solutions.iter().zip(weights) {
            let solution = &span_solution.solution;
            let time = weight.abs() / all * duration;
            self.accumulated_model_error.add_model_error(time, solution);
            for (sum, bars) in [
                (&mut self.error_estimate, &solution.error_estimate),
                (&mut self.rotation_error, &solution.angular_velocity_error),
                (&mut self.work_error, &solution.power_error),
            ] {
                sum.accumulate(time, &without_mesh(bars));
            }
        }
        self.accumulated_integration_error =
            match (self.accumulated_integration_error.take(), integration_error) {
                (Some(mut sum), Some(part)) => {
                    sum.append_correlated(&part, &displacement);
                    Some(sum)
                }
                _ => None,
            };
        let bars = (self.accumulated_integration_error.as_ref())
            .map(|error| error.uncorrected_error_bars(error.largest_displacement()));
        self.error_estimate.integration = bars.map(|bars| bars.displacement);
        self.rotation_error.integration = bars.map(|bars| bars.rotation);
        self.work_error.integration = bars.map(|bars| bars.work);
        let set = evaluator.scene.articulation();
        let end = piece.state(set, piece.to)?;
        self.end = set.closed(&end, &evaluator.span.shape(piece.to))?;
        self.solutions.extend(solutions);
        self.pieces.push(piece);
        Ok(())
    }

    /// Keeps of the solutions of the last part that at its start alone: other stages of an explicit
    /// method are not on the path.
    pub(super) fn keep_first_stage(&mut self, stages: usize) {
        let kept = self.solutions.len() + 1 - stages;
        self.solutions.truncate(kept);
    }

    /// Adds the solution at the end, which no part has.
    pub(super) fn end_with(&mut self, solution: SpanSolution) {
        self.solutions.push(solution);
    }

    /// The error that ends the integration here, with this result if it is the motion up to there.
    pub(super) fn stopped(self, evaluator: &SpanEvaluator, error: SwimError) -> Stopped {
        let keeps = error.ends_motion();
        Stopped {
            error: Box::new(error),
            so_far: keeps.then(|| Box::new(self.with_totals(evaluator))),
        }
    }

    /// The position on the phase span at which the result ends: one, or where the motion stopped.
    pub fn reached(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.to)
    }

    /// The result with the number and the time of all solves of the evaluator.
    pub(super) fn with_totals(self, evaluator: &SpanEvaluator) -> Self {
        Self {
            solves: evaluator.solves,
            lookups: evaluator.lookups,
            tables: evaluator.tables.clone(),
            seconds: evaluator.seconds,
            ..self
        }
    }
}
