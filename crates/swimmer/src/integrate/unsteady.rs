//! Phase spans in a fluid with inertia: steps in time of fluid and bodies together.
//!
//! [`MovingFluid`] is the seam between this loop and what takes the steps: three-dimensional meshes
//! ([`super::spatial_fluid`]), the meridian plane ([`super::meridian_fluid`]), and two of them that
//! move side by side to estimate the error of the mesh ([`super::companion`]).

use inertia::linalg::StepControl;
use models::{AccumulatedError, ModelError};
use nalgebra::Vector3;
use rigid::{State, StateBounds, Twist};
use scene::{Gait, PhaseSpan, Scene, StartKind, spans};

use super::meridian_fluid::{MeridianFluid, MeridianScene};
use super::moving_fluid::{
    BodyMemory, LEAST_PART, LEAST_STEP, MeshError, MovingFluid, TriedStep, UnsteadyState, position,
};
use super::piece::PathPiece;
use super::result::{Accumulated, Approximation, IntegrationError, SpanResult, Stopped};
use super::span_evaluator::{SpanEvaluator, SpanSolution};
use super::spatial_fluid::{SpatialFluid, SpatialScene};
use crate::error::SwimError;
use crate::planning::{Discretisation, discretisation};

/// Bodies, loads and slip of a scene whose fluid has inertia, along its gait.
pub struct UnsteadyScene {
    scene: Scene,
    forced: ForcedScene,
}

/// A scene in one discretisation, and with fewer degrees of freedom for an estimate of the error of
/// the mesh.
enum ForcedScene {
    Spatial(Box<SpatialScene>, Option<Box<SpatialScene>>),
    Meridian(Box<[MeridianScene; 2]>),
}

impl UnsteadyScene {
    /// Prepares a scene; `None` if its fluid has no inertia.
    ///
    /// # Errors
    /// Joints or fixed bodies that contradict each other; a mesh file that cannot be read.
    pub fn new(scene: &Scene) -> Result<Option<Self>, ModelError> {
        if !scene.inertia().is_kept() {
            return Ok(None);
        }
        let forced = match discretisation(scene)? {
            Discretisation::Meridian => {
                ForcedScene::Meridian(Box::new(MeridianScene::pair(scene)?))
            }
            Discretisation::Spatial => {
                let coarse = SpatialScene::coarser(scene)?.map(Box::new);
                ForcedScene::Spatial(Box::new(SpatialScene::new(scene)?), coarse)
            }
        };
        Ok(Some(Self {
            scene: scene.clone(),
            forced,
        }))
    }

    /// Fluid and bodies at rest at the start of the gait.
    fn at_rest(&self) -> Result<Box<dyn MovingFluid + '_>, SwimError> {
        match &self.forced {
            ForcedScene::Spatial(finest, coarse) => {
                SpatialFluid::with_companion(finest, coarse.as_deref())
            }
            ForcedScene::Meridian(both) => MeridianFluid::with_companion(both),
        }
    }
}

/// Fluid and bodies up to the present time, with what chooses the next step.
pub(crate) struct UnsteadyFlow<'a> {
    scene: &'a Scene,
    fluid: Box<dyn MovingFluid + 'a>,
    /// Time of the fluid when that of the gait is zero.
    origin: f64,
    /// The phase span that is integrated, in the time of the fluid; none before the first.
    span: Option<PhaseSpan>,
    /// Length of the last step that its error chose; none before the first.
    length: Option<f64>,
    /// Estimated error of the velocities of surfaces so far, in the units of the scene: those of
    /// all steps, as far as they are not forgotten.
    velocity_error: f64,
    memory: BodyMemory,
}

/// Bounds of the first step after a jump of velocities, relative to the duration of the phase.
///
/// The flow grows like `t^(1/2)` there. Steps grow until their error limits them, so a shorter
/// first step costs one step per factor of growth.
const FIRST_STEP: [f64; 2] = [1e-5, 1e-3];

/// Net displacement by the error of a first step of the length `h` over that of a body with the
/// speed of the jump during `(h τ)^(1/2)`, with the time `τ` in which vorticity leaves the body.
///
/// The error of the impulse of the layer is such a displacement, of which phases in which arms
/// close and open leave a small part: 2e-4 in the stroke of three spheres at a Reynolds number of
/// 1, whose net displacement changed by 1.5e-5 of 0.0834 with `h` from 1e-5 to 1e-4 of a phase. The
/// rest is a reserve, because the companion takes the same first step, so that no bar contains it.
const NET_OF_FIRST_STEP: f64 = 0.003;

/// Difference of rates between phases, relative to the largest, that is no corner of the gait.
const CORNER: f64 = 1e-6;

/// Part of the tolerance of a phase that one step may use if it is as long as the phase.
///
/// Steps of equal length that use all they may have errors `σ (τ / T)^(1/2)` and add up to `σ
/// n^(1/2)`, with 16 to 64 steps in a phase.
const STEP_SHARE: f64 = 0.25;

/// Length relative to the phase below which all steps may use the same: those after a jump double,
/// so that they are few.
const SHORT_STEP: f64 = 1e-2;

impl<'a> UnsteadyFlow<'a> {
    /// Fluid and bodies at rest at the start of the gait.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    pub fn new(scene: &'a UnsteadyScene) -> Result<Self, SwimError> {
        Ok(Self {
            fluid: scene.at_rest()?,
            scene: &scene.scene,
            origin: 0.0,
            span: None,
            length: None,
            velocity_error: 0.0,
            memory: BodyMemory::new(&scene.scene),
        })
    }

    /// Continues after a phase span, from what was remembered at its end.
    ///
    /// # Errors
    /// What does not fit the scene or the end of the phase span.
    pub fn continue_after(
        &mut self,
        span: &PhaseSpan,
        state: UnsteadyState,
    ) -> Result<(), SwimError> {
        let span = in_time_of_fluid(span, state.origin);
        self.fluid.enter(&span);
        self.fluid.continue_from(state.fluid)?;
        let distance = (self.fluid.time() - (span.start + span.duration)).abs();
        let is_length = state.length.is_none_or(|length| length > 0.0);
        let is_end = distance <= LEAST_STEP * span.duration;
        if !is_end || !is_length || state.velocity_error < 0.0 {
            let problem = "has a fluid of another time than the end of the last phase".to_owned();
            return Err(ModelError::History(problem).into());
        }
        self.origin = state.origin;
        self.span = Some(span);
        self.length = state.length;
        self.velocity_error = state.velocity_error;
        Ok(())
    }

    /// What the next phase span depends on.
    fn remembered(&mut self) -> Result<UnsteadyState, SwimError> {
        Ok(UnsteadyState {
            fluid: self.fluid.remembered()?,
            origin: self.origin,
            length: self.length,
            velocity_error: self.velocity_error,
        })
    }

    /// Lets the time of the gait begin again at zero, also for the state that was remembered.
    pub fn begin_again(&mut self, remembered: &mut UnsteadyState) {
        self.origin = self.fluid.time();
        remembered.origin = self.origin;
    }

    /// Enters a phase span in the time of the fluid; whether velocities jump at its start.
    fn enter(&mut self, span: &PhaseSpan) -> Result<bool, SwimError> {
        self.fluid.enter(span);
        let Some(before) = self.span.replace(span.clone()) else {
            if self.scene.inertia().start == StartKind::Stokes {
                self.fluid.start_from_stokes(span)?;
                return Ok(false);
            }
            return Ok(true);
        };
        let (rates, last) = (span.rates(0.0), before.rates(1.0));
        let largest = rates
            .iter()
            .chain(&last)
            .fold(0.0_f64, |m, x| m.max(x.abs()));
        let differ = |(a, b): (&f64, &f64)| (a - b).abs() > CORNER * largest;
        let jumps = rates.iter().zip(&last).any(differ);
        if jumps {
            self.fluid.restart();
        }
        Ok(jumps)
    }

    /// A step of this length, or of less where the mesh cannot follow a longer one or its equations
    /// are not solved.
    fn step(&mut self, wanted: f64, least: f64) -> Result<TriedStep, SwimError> {
        let mut length = wanted;
        let shortest = least.max(LEAST_PART * wanted);
        loop {
            match self.fluid.try_step(length) {
                Err(error) if error.needs_shorter_step() && length > shortest => length *= 0.5,
                result => return result,
            }
        }
    }
}

/// A phase span in the time of the fluid, which is `origin` at the start of the gait.
fn in_time_of_fluid(span: &PhaseSpan, origin: f64) -> PhaseSpan {
    let mut span = span.clone();
    span.start += origin;
    span
}

/// Integrates a phase span by steps in time whose errors the tolerance of the phase limits, or that
/// have the length that the scene prescribes.
pub(super) fn span(
    evaluator: &mut SpanEvaluator,
    start: &State,
    flow: &mut UnsteadyFlow,
) -> Result<SpanResult, Stopped> {
    let mut result = SpanResult::empty(start);
    let integrated = integrate(evaluator, flow, &mut result).and_then(|()| flow.remembered());
    match integrated {
        Ok(state) => Ok(SpanResult {
            fluid: Some(state),
            ..result.with_totals(evaluator)
        }),
        Err(error) => Err(result.stopped(evaluator, error)),
    }
}

fn integrate(
    evaluator: &mut SpanEvaluator,
    flow: &mut UnsteadyFlow,
    result: &mut SpanResult,
) -> Result<(), SwimError> {
    let scene = evaluator.scene;
    let span = &in_time_of_fluid(evaluator.span, flow.origin);
    let jumps = flow.enter(span)?;
    let least = LEAST_STEP * span.duration;
    let tolerance = evaluator
        .tolerance
        .unwrap_or_else(|| fallback_tolerance(evaluator));
    let fixed = scene.inertia().time_step;
    // Until the first step after a jump, nothing is known of errors.
    let first = match (fixed, jumps, flow.length) {
        (Some(fixed), ..) => span.duration / (span.duration / fixed).ceil(),
        (None, false, Some(length)) => length,
        (None, ..) => first_step(evaluator, tolerance, flow.memory),
    };
    let mut steps = StepControl::new(first, least);
    let mut forgets = jumps && fixed.is_none();
    let end = span.start + span.duration;
    let mut last: Option<TakenStep> = None;
    while end - flow.fluid.time() > least {
        let (time, before) = (flow.fluid.time(), steps.length());
        let wanted = steps.next(end - time);
        let step = flow.step(wanted, least)?;
        let taken = step.length;
        if fixed.is_none() {
            let share = STEP_SHARE * (taken / span.duration).max(SHORT_STEP).sqrt();
            let error = step.displacement_error;
            let allowed = share * tolerance;
            let accepted = steps.accepts(time, taken, error, allowed);
            let parts = (span.duration / taken).round() as usize;
            let short = |_| evaluator.not_integrated(error, allowed, parts);
            if !accepted.map_err(short)? {
                continue;
            }
            if taken < wanted {
                // The step that was wanted failed.
                steps.shorten(taken);
            } else {
                // The last step of a phase may be shorter and says nothing about the next.
                steps.shorten(flow.fluid.max_growth() * before);
            }
        } else if taken < wanted {
            // Given steps stay as short for the rest of the phase.
            steps.shorten(taken);
        }
        match append(evaluator, flow, result, step, last.as_ref()) {
            Err(error) if error.is_overshoot() && taken > least && fixed.is_none() => {
                steps.shorten(0.5 * taken);
                continue;
            }
            solution => last = Some(solution?),
        }
        flow.length = Some(steps.length());
        if std::mem::take(&mut forgets) {
            // The level before the jump has other velocities.
            flow.fluid.restart();
        }
    }
    Ok(())
}

/// The solution at the end of a step, with what the next one needs to know of this one.
struct TakenStep {
    end: SpanSolution,
    length: f64,
    /// Change of the power in it; none in the first step.
    power_change: Option<f64>,
}

/// Accepts a step and appends it to the result, after a check that nothing touches along it.
fn append(
    evaluator: &mut SpanEvaluator,
    flow: &mut UnsteadyFlow,
    result: &mut SpanResult,
    step: TriedStep,
    last: Option<&TakenStep>,
) -> Result<TakenStep, SwimError> {
    let set = evaluator.scene.articulation();
    let span = &in_time_of_fluid(evaluator.span, flow.origin);
    let start = flow.fluid.time();
    let part = (position(span, start), position(span, start + step.length));
    let TriedStep {
        length,
        increment,
        mesh_error,
        error,
        velocity_error,
        jump,
        ..
    } = step;
    let piece = PathPiece::new(set, &result.end, part, vec![increment])?;
    evaluator.check_path(&piece)?;
    let solution = flow.fluid.solution(evaluator.flows)?;
    let added_mass = flow.fluid.added_mass_forces()?;
    flow.fluid.accept()?;
    let energy = Some(flow.fluid.kinetic_energy()?);
    let state = piece.state(set, part.1)?;
    let of_inertia = (energy, added_mass);
    let recorded = evaluator.record_with_inertia(part.1, &state, solution, of_inertia)?;
    // Where nothing is known of the error of a step, it is smaller than the change in it, or in the
    // next step.
    let change = last.map_or(0.0, |last| {
        let bodies = recorded
            .solution
            .bodies
            .iter()
            .zip(&last.end.solution.bodies);
        bodies.fold(0.0, |m: f64, (a, b)| {
            m.max((a.velocity - b.velocity).norm())
        })
    });
    let kept = (-length / flow.memory.total()).exp();
    flow.velocity_error *= kept;
    flow.velocity_error += jump;
    flow.velocity_error += match velocity_error.is_finite() {
        true => velocity_error,
        false => change,
    };
    let mut displacement = length * flow.velocity_error;
    if last.is_none()
        && !velocity_error.is_finite()
        && evaluator.scene.inertia().time_step.is_some()
    {
        // A first step of a given length, in which the velocity may have been anything from none to
        // twice that at its end; those that are chosen are very short.
        let bodies = recorded.solution.bodies.iter();
        let largest = bodies.fold(0.0_f64, |m, body| m.max(body.velocity.norm()));
        displacement += 0.5 * length * largest;
    }
    let start = last.map_or(&recorded, |last| &last.end);
    let power = recorded.solution.power();
    let power_change = last.map(|last| power - last.end.solution.power());
    // from the power at the end of the step to a linear one, and on to a quadratic one
    let linear = -0.5 * length * power_change.unwrap_or(0.0);
    let quadratic = last.and_then(|last| {
        let [before, now] = [last.power_change? / last.length, power_change? / length];
        Some(-length.powi(3) / 6.0 * (now - before) / (length + last.length))
    });
    let integration = IntegrationError {
        displacement,
        rotation: displacement / smallest_radius(evaluator.scene),
        work: quadratic.unwrap_or(linear).abs() + length * power.abs() * error.min(1.0),
        // As for the work, but with the load at the end of the step.
        holding: holding_change(start, &recorded).map(|change| length * change),
    };
    let accumulated = mesh_error.map(|error| of_mesh(&error, &recorded, length));
    let approximation = Approximation::new(piece, vec![recorded.clone()], vec![1.0]);
    result.append(
        evaluator,
        approximation,
        Some(integration.unsigned()),
        accumulated.as_ref().map(Accumulated::Correlated),
    )?;
    result.work += linear + quadratic.unwrap_or(0.0);
    let twists = recorded.solution.bodies.iter();
    result.velocities = twists
        .flat_map(|body| [body.velocity, body.angular_velocity])
        .flat_map(|v| [v.x, v.y, v.z])
        .collect();
    Ok(TakenStep {
        end: recorded,
        length,
        power_change,
    })
}

/// The error by the mesh of a step, from that of the change of the state and of the solution at its
/// end.
fn of_mesh(error: &MeshError, recorded: &SpanSolution, length: f64) -> AccumulatedError {
    let solution = &recorded.solution;
    let frames = || error.change.frames.iter();
    let largest = |of: fn(&Twist) -> Vector3<f64>| {
        error.own_uncertainty * frames().map(|frame| of(frame).norm()).fold(0.0, f64::max)
    };
    let work = (solution.uncorrected_power() - solution.power()) * length;
    AccumulatedError {
        displacement: frames().map(|frame| frame.linear).collect(),
        rotation: frames().map(|frame| frame.angular).collect(),
        uncertainty: largest(|frame| frame.linear),
        rotation_uncertainty: largest(|frame| frame.angular),
        work,
        work_uncertainty: error.own_uncertainty * work.abs(),
        relative_uncertainty: error.relative_uncertainty,
        ..AccumulatedError::default()
    }
}

/// The smallest radius of a body with a surface.
fn smallest_radius(scene: &Scene) -> f64 {
    let radii = scene.bodies().iter().map(scene::Body::bounding_radius);
    radii
        .filter(|radius| *radius > 0.0)
        .fold(f64::INFINITY, f64::min)
}

/// Largest changes of the forces and torques that hold bodies.
fn holding_change(from: &SpanSolution, to: &SpanSolution) -> [f64; 2] {
    let pairs = from.solution.holding.iter().zip(&to.solution.holding);
    pairs.fold([0.0; 2], |[force, torque]: [f64; 2], (a, b)| {
        let (f, t) = ((a.force - b.force).norm(), (a.torque - b.torque).norm());
        [force.max(f), torque.max(t)]
    })
}

/// Length of the first step after a jump of velocities, for this tolerance of the phase.
///
/// [`NET_OF_FIRST_STEP`] is that of phases after which all rigid bodies have moved back; masses and
/// loads have other times. Elsewhere it is the shortest.
fn first_step(evaluator: &SpanEvaluator, tolerance: f64, memory: BodyMemory) -> f64 {
    let (scene, duration) = (evaluator.scene, evaluator.span.duration);
    let [shortest, longest] = FIRST_STEP.map(|part| part * duration);
    let returns = memory.inertia == 0.0 && !scene.has_loads() && moves_joints_alone(scene);
    let speed = match returns && gait_returns(scene) {
        true => fastest_way(evaluator) / duration,
        false => f64::NAN,
    };
    let way = tolerance / (NET_OF_FIRST_STEP * speed);
    match speed > 0.0 {
        true => (way * way / memory.diffusion).clamp(shortest, longest),
        false => shortest,
    }
}

/// Whether nothing but joints between rigid bodies moves them.
fn moves_joints_alone(scene: &Scene) -> bool {
    let (set, bodies) = (scene.articulation(), scene.bodies());
    !scene.has_surface_velocity()
        && set.held_bodies().all(|body| bodies[body].fixed)
        && !set.joints().iter().any(|joint| joint.kind.is_deformation())
}

/// Whether the prescribed joints have their first values after a cycle.
fn gait_returns(scene: &Scene) -> bool {
    let gait = Gait {
        cycles: 1,
        phases: scene.gait().phases.clone(),
    };
    let start = scene.articulation().initial_shape();
    let last = spans(&gait, start).ok().and_then(Iterator::last);
    last.is_some_and(|last| scene.shape_changes(start, &last.to).is_empty())
}

/// Upper bound of the way of a point of a body over the phase span at the largest rates of the
/// joints, as seen from the frame of its linkage.
fn fastest_way(evaluator: &SpanEvaluator) -> f64 {
    let (scene, span) = (evaluator.scene, evaluator.span);
    let set = scene.articulation();
    let joints = span.value_bounds(&span.second_derivatives(), (0.0, 1.0));
    let motions = set.motion_bounds(&StateBounds::at_rest(set, joints));
    let motions = motions.iter().flatten().zip(scene.bodies());
    let ways = motions
        .map(|(motion, body)| motion.linear.first + motion.angular.first * body.bounding_radius());
    ways.fold(0.0, f64::max)
}

/// The longest change of a joint over the phase span, or way at the speed of a slip; zero without
/// both.
fn longest_way(evaluator: &SpanEvaluator) -> f64 {
    let (scene, span) = (evaluator.scene, evaluator.span);
    let changes = evaluator.ranges.iter().map(|(low, high)| high - low);
    let slips = scene.bodies().iter().filter_map(|body| body.slip);
    let ways = slips.map(|slip| slip.speed() * span.duration);
    changes.chain(ways).fold(0.0, f64::max)
}

/// Integration error of a phase span where the net displacement is not predicted: relative to the
/// longest change of a joint or the way at the speed of a slip; without both, to the largest body.
fn fallback_tolerance(evaluator: &SpanEvaluator) -> f64 {
    let scene = evaluator.scene;
    let length = longest_way(evaluator);
    let sizes = scene.bodies().iter().map(scene::Body::bounding_radius);
    let length = match length > 0.0 {
        true => length,
        false => sizes.fold(0.0, f64::max),
    };
    scene.working_tolerance() * length
}
