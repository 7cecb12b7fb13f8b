//! Phase spans in a fluid with inertia: steps in time of fluid and bodies together.

use std::f64::consts::PI;
use std::sync::{PoisonError, RwLock};

use inertia::linalg::step_factor;
use inertia::{
    Bodies, BodyMass, Convection, Forcing, InertiaError, Integrator, Meshes, Parameters, Step,
};
use mesh::TetMesh;
use models::{InstantaneousSolution, ModelError, MovingMeshes, MovingScene};
use nalgebra::{Isometry3, Vector3};
use rigid::{Constraints, ExternalLoad, RigidError, State};
use scene::{InertiaKind, PhaseSpan, Scene, StartKind};

use super::piece::PathPiece;
use super::result::{Approximation, IntegrationError, SpanResult, Stopped};
use super::span_evaluator::{SpanEvaluator, SpanSolution};
use crate::error::SwimError;

/// Bodies, loads and slip of a scene whose fluid has inertia, along its gait.
pub struct UnsteadyScene {
    moving: MovingScene,
    /// The phase span that is integrated; none before the first.
    span: RwLock<Option<PhaseSpan>>,
}

impl UnsteadyScene {
    /// Prepares a scene; `None` if its fluid has no inertia.
    ///
    /// # Errors
    /// Those of [`MovingScene::new`].
    pub fn new(scene: &Scene) -> Result<Option<Self>, ModelError> {
        if !scene.inertia().is_kept() {
            return Ok(None);
        }
        Ok(Some(Self {
            moving: MovingScene::new(scene)?,
            span: RwLock::new(None),
        }))
    }

    /// Replaces the phase span, and returns the one before.
    fn enter(&self, span: &PhaseSpan) -> Option<PhaseSpan> {
        // No value is half written if a thread panics here.
        let mut present = self.span.write().unwrap_or_else(PoisonError::into_inner);
        present.replace(span.clone())
    }
}

impl Forcing for UnsteadyScene {
    fn shape(&self, time: f64) -> Vec<f64> {
        let span = self.span.read().unwrap_or_else(PoisonError::into_inner);
        match &*span {
            Some(span) => self.moving.shape(&span.shape(position(span, time))),
            None => {
                let set = self.moving.scene().articulation();
                self.moving.shape(set.initial_shape())
            }
        }
    }

    fn loads(&self, time: f64, poses: &[Isometry3<f64>]) -> Vec<ExternalLoad> {
        self.moving.loads(time, poses)
    }

    fn constraints(&self, time: f64, joints: Constraints) -> Result<Constraints, RigidError> {
        self.moving.constraints(time, joints)
    }

    fn has_slip(&self) -> bool {
        self.moving.has_slip()
    }

    fn slip(&self, _: f64, body: usize, x: &Vector3<f64>) -> Vector3<f64> {
        self.moving.slip(body, x)
    }
}

/// Position on a phase span at a time.
fn position(span: &PhaseSpan, time: f64) -> f64 {
    ((time - span.start) / span.duration).clamp(0.0, 1.0)
}

/// Meshes of a scene for an integrator in time.
struct SceneMeshes(MovingMeshes);

impl Meshes for SceneMeshes {
    fn mesh(&mut self, _: f64, poses: &[Isometry3<f64>]) -> Result<Option<TetMesh>, InertiaError> {
        self.0.moved(poses).map_err(supplied)
    }

    fn renew(&mut self, _: f64, poses: &[Isometry3<f64>]) -> Result<Option<TetMesh>, InertiaError> {
        self.0.renewed(poses).map(Some).map_err(supplied)
    }
}

fn supplied(error: ModelError) -> InertiaError {
    InertiaError::Supplier(Box::new(error))
}

/// The motion of fluid and bodies up to the present time.
pub(crate) struct UnsteadyFlow<'a> {
    scene: &'a UnsteadyScene,
    integrator: Integrator<'a>,
    /// Length of the last step that its error chose; none before the first.
    length: Option<f64>,
    /// Estimated error of the velocities of surfaces so far, in the units of the scene: those of
    /// all steps, as far as they are not forgotten.
    velocity_error: f64,
    /// Time after which bodies have forgotten an error of their velocities.
    memory: f64,
}

/// First step after a jump of velocities, relative to the duration of the phase.
///
/// The flow grows like `t^(1/2)` there. Steps double until their error limits them, so a shorter
/// first step costs one step per factor of two.
const FIRST_STEP: f64 = 1e-4;

/// Difference of rates between phases, relative to the largest, that is no corner of the gait.
const CORNER: f64 = 1e-6;

/// Shortest step relative to the phase.
const LEAST_STEP: f64 = 1e-9;

/// Part of the tolerance of a phase that one step may use if it is as long as the phase.
///
/// Steps of equal length that use all they may have errors `σ (τ / T)^(1/2)` and add up to `σ
/// n^(1/2)`, with 16 to 64 steps in a phase.
const STEP_SHARE: f64 = 0.25;

impl<'a> UnsteadyFlow<'a> {
    /// Fluid and bodies at rest at the start of the gait.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated.
    pub fn new(scene: &'a UnsteadyScene) -> Result<Self, SwimError> {
        let moving = &scene.moving;
        let masses = moving.masses().into_iter();
        let bodies = Bodies {
            set: moving.set(),
            masses: masses
                .map(|(mass, inertia)| BodyMass { mass, inertia })
                .collect(),
            surfaces: moving.surface_names().to_vec(),
            walls: moving.walls().to_vec(),
        };
        let convection = match moving.scene().inertia().kind {
            InertiaKind::Full => Convection::Full,
            _ => Convection::Neglected,
        };
        let parameters = Parameters::new(moving.density())
            .with_convection(convection)
            .with_options(moving.options());
        let meshes = Box::new(SceneMeshes(moving.meshes()?));
        Ok(Self {
            integrator: Integrator::from_rest(bodies, scene, meshes, parameters, 0.0)?,
            scene,
            length: None,
            velocity_error: 0.0,
            memory: memory(moving.scene()),
        })
    }

    /// Time over which an error of a velocity counts that a step of this length makes.
    fn weight(&self, length: f64) -> f64 {
        length + self.memory
    }

    /// Enters a phase span; whether velocities jump at its start.
    fn enter(&mut self, span: &PhaseSpan) -> Result<bool, SwimError> {
        let before = self.scene.enter(span);
        let rates = span.rates(0.0);
        let Some(before) = before else {
            if self.scene.moving.scene().inertia().start == StartKind::Stokes {
                let scaled = self.scene.moving.shape(&rates);
                self.integrator.start_from_stokes(&scaled)?;
                return Ok(false);
            }
            return Ok(true);
        };
        let last = before.rates(1.0);
        let largest = rates
            .iter()
            .chain(&last)
            .fold(0.0_f64, |m, x| m.max(x.abs()));
        let differ = |(a, b): (&f64, &f64)| (a - b).abs() > CORNER * largest;
        let jumps = rates.iter().zip(&last).any(differ);
        if jumps {
            self.integrator.restart();
        }
        Ok(jumps)
    }

    /// A step of this length, or of less where the mesh cannot follow a longer one.
    fn step(&mut self, mut length: f64, least: f64) -> Result<Step, SwimError> {
        loop {
            match self.integrator.try_step(length) {
                Err(InertiaError::NoMesh { .. }) if length > least => length *= 0.5,
                result => return Ok(result?),
            }
        }
    }
}

/// Time after which the velocity of the slowest body does not know any more how it began.
///
/// After an impulse the velocity decays within `m / (6π μ a)` by the drag, and within the time
/// `ρ a² / μ` in which vorticity leaves the body, after which it is below `t^(-3/2)` (Hinch 1975).
fn memory(scene: &Scene) -> f64 {
    let of_body = |body: &scene::Body| {
        let (radius, mass) = (body.bounding_radius(), body.mass_matrix_by_density());
        let diffusion = scene.fluid_density() * radius * radius;
        match radius > 0.0 {
            true => diffusion + mass.map_or(0.0, |(mass, _)| mass / (6.0 * PI * radius)),
            false => 0.0,
        }
    };
    let slowest = scene.bodies().iter().map(of_body).fold(0.0, f64::max);
    slowest / scene.viscosity()
}

/// Integrates a phase span by steps in time whose errors the tolerance of the phase limits, or that
/// have the length that the scene prescribes.
pub(super) fn span(
    evaluator: &mut SpanEvaluator,
    start: &State,
    flow: &mut UnsteadyFlow,
) -> Result<SpanResult, Stopped> {
    let mut result = SpanResult::empty(start);
    match integrate(evaluator, flow, &mut result) {
        Ok(()) => Ok(result.with_totals(evaluator)),
        Err(error) => Err(result.stopped(evaluator, error)),
    }
}

fn integrate(
    evaluator: &mut SpanEvaluator,
    flow: &mut UnsteadyFlow,
    result: &mut SpanResult,
) -> Result<(), SwimError> {
    let (scene, span) = (evaluator.scene, evaluator.span);
    let jumps = flow.enter(span)?;
    let least = LEAST_STEP * span.duration;
    let tolerance = evaluator
        .tolerance
        .unwrap_or_else(|| fallback_tolerance(evaluator));
    let fixed = scene.inertia().time_step;
    // Until the first step after a jump, nothing is known of errors.
    let mut length = match (fixed, jumps, flow.length) {
        (Some(fixed), ..) => span.duration / (span.duration / fixed).ceil(),
        (None, false, Some(length)) => length,
        (None, ..) => FIRST_STEP * span.duration,
    };
    let mut forgets = jumps && fixed.is_none();
    let end = span.start + span.duration;
    let mut last: Option<SpanSolution> = None;
    while end - flow.integrator.time() > least {
        let left = end - flow.integrator.time();
        // No rest that is shorter than half a step.
        let taken = match left < 1.5 * length && left > length * (1.0 + 1e-9) {
            true => 0.5 * left,
            false => length.min(left),
        };
        let step = flow.step(taken, least)?;
        let taken = step.length;
        let share = STEP_SHARE * (taken / span.duration).sqrt();
        let allowed = share * tolerance / flow.weight(taken);
        let error = flow.scene.moving.length_to_scene(step.velocity_error);
        // After a jump nothing is known of the error.
        if fixed.is_none() && error.is_finite() && error > allowed {
            length = taken * step_factor(allowed, error).min(0.9);
            if length <= least {
                return Err(evaluator.not_integrated(error * taken, tolerance, usize::MAX));
            }
            continue;
        }
        let is_shorter = taken < 0.99 * length;
        if fixed.is_none() && error.is_finite() && !is_shorter {
            length = taken * step_factor(allowed, error);
        } else if is_shorter && fixed.is_none() && taken < 0.4 * length && left > length {
            // The mesh could not follow the step.
            length = taken;
        }
        match append(evaluator, flow, result, step, last.as_ref()) {
            Err(error) if error.is_overshoot() && taken > least && fixed.is_none() => {
                length = 0.5 * taken;
                continue;
            }
            solution => last = Some(solution?),
        }
        flow.length = Some(length);
        if std::mem::take(&mut forgets) {
            // The level before the jump has other velocities.
            flow.integrator.restart();
        }
    }
    Ok(())
}

/// Accepts a step and appends it to the result, after a check that nothing touches along it.
fn append(
    evaluator: &mut SpanEvaluator,
    flow: &mut UnsteadyFlow,
    result: &mut SpanResult,
    mut step: Step,
    last: Option<&SpanSolution>,
) -> Result<SpanSolution, SwimError> {
    let (span, moving) = (evaluator.span, &flow.scene.moving);
    let set = evaluator.scene.articulation();
    let part = (
        position(span, step.time - step.length),
        position(span, step.time),
    );
    let increment = step
        .increment()
        .map(|increment| moving.motion_to_scene(increment));
    let rates = increment.into_iter().collect();
    let piece = PathPiece::new(set, &result.end, part, rates)?;
    evaluator.check_path(&piece)?;
    let solution = answer(evaluator, flow, &mut step)?;
    let (relative, error) = (step.error, moving.length_to_scene(step.velocity_error));
    let (length, smallest) = (step.length, 1.0 / moving.length(1.0));
    flow.integrator.accept(step)?;
    let recorded = evaluator.record(part.1, &piece.state(set, part.1)?, solution)?;
    // Where nothing is known of the error of a step, it is smaller than the change in it, or in the
    // next step.
    let change = last.map_or(0.0, |last| {
        let bodies = recorded.solution.bodies.iter().zip(&last.solution.bodies);
        bodies.fold(0.0, |m: f64, (a, b)| {
            m.max((a.velocity - b.velocity).norm())
        })
    });
    let kept = (-length / flow.memory).exp();
    flow.velocity_error *= kept;
    flow.velocity_error += if error.is_finite() { error } else { change };
    let displacement = length * flow.velocity_error;
    let powers = [last.unwrap_or(&recorded), &recorded].map(|at| at.solution.power());
    let trapezium = 0.5 * length * (powers[0] - powers[1]);
    let error = IntegrationError {
        displacement,
        rotation: displacement / smallest,
        work: trapezium.abs() + length * powers[1].abs() * relative.min(1.0),
        // As for the work, but without the better value by the trapezium.
        holding: holding_change(last.unwrap_or(&recorded), &recorded).map(|change| length * change),
    };
    let approximation = Approximation {
        piece,
        solutions: vec![recorded.clone()],
        weights: vec![1.0],
    };
    result.append(evaluator, approximation, Some(error.unsigned()), None)?;
    result.work += trapezium;
    let twists = recorded.solution.bodies.iter();
    result.velocities = twists
        .flat_map(|body| [body.velocity, body.angular_velocity])
        .flat_map(|v| [v.x, v.y, v.z])
        .collect();
    Ok(recorded)
}

/// Largest changes of the forces and torques that hold bodies.
fn holding_change(from: &SpanSolution, to: &SpanSolution) -> [f64; 2] {
    let pairs = from.solution.holding.iter().zip(&to.solution.holding);
    pairs.fold([0.0; 2], |[force, torque]: [f64; 2], (a, b)| {
        let (f, t) = ((a.force - b.force).norm(), (a.torque - b.torque).norm());
        [force.max(f), torque.max(t)]
    })
}

/// The solution of a step in the units of the scene, with its flow if observers want it.
fn answer(
    evaluator: &SpanEvaluator,
    flow: &UnsteadyFlow,
    step: &mut Step,
) -> Result<InstantaneousSolution, SwimError> {
    let mesh = evaluator.flows.then(|| step.mesh().clone());
    Ok((flow.scene.moving).answer(&mut step.solved, &step.poses, mesh)?)
}

/// Integration error of a phase span where the net displacement is not predicted: relative to the
/// longest change of a joint or the way at the speed of a slip; without both, to the largest body.
fn fallback_tolerance(evaluator: &SpanEvaluator) -> f64 {
    let (scene, span) = (evaluator.scene, evaluator.span);
    let changes = evaluator.ranges.iter().map(|(low, high)| high - low);
    let slips = scene.bodies().iter().filter_map(|body| body.slip);
    let ways = slips.map(|slip| slip.speed() * span.duration);
    let length = changes.chain(ways).fold(0.0, f64::max);
    let sizes = scene.bodies().iter().map(scene::Body::bounding_radius);
    let length = match length > 0.0 {
        true => length,
        false => sizes.fold(0.0, f64::max),
    };
    scene.working_tolerance() * length
}
