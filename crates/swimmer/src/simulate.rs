//! Simulation of a whole gait.

use models::{Hydrodynamics, NewMesh};
use scene::{PhaseSpan, Scene, spans};

use crate::checkpoint;
use crate::error::SwimError;
use crate::integrate::{Integrator, Method, SpanResult, SpanSolution, UnsteadyScene};
use crate::moment::check_model;
use crate::observer::Observer;
use crate::outcome::{Interim, Outcome};
use crate::periodic::start_of_gait;

/// Moves the bodies of a scene through all cycles of its gait, from the periodic state if the scene
/// says so ([`start_of_gait`]).
///
/// The observer sees the gait, not the search for the periodic state.
///
/// # Errors
/// A scene without a gait; [`SwimError::OtherScene`] for a model of another scene;
/// [`SwimError::NoSteps`]; [`SwimError::NotPeriodic`] and [`SwimError::NotPeriodicFlow`]; errors of
/// the model, the integration and the observer.
///
/// # Examples
/// A model outside this workspace:
///
/// ```
/// use swimmer::models::{
///     BodySolution, Hydrodynamics, InstantaneousSolution, ModelError, Query,
/// };
/// use swimmer::{Method, Scene, simulate};
///
/// /// A model in which the first body is at rest.
/// struct Anchor(Scene);
///
/// impl Hydrodynamics for Anchor {
///     fn name(&self) -> &'static str {
///         "anchor"
///     }
///
///     fn scene(&self) -> &Scene {
///         &self.0
///     }
///
///     fn solve(&mut self, query: &Query) -> Result<Vec<InstantaneousSolution>, ModelError> {
///         let (set, at) = (self.0.articulation(), query.configuration);
///         let one = |rates: &Vec<f64>| {
///             let constraints = set.constraints(at.state, at.shape, rates)?;
///             let reduction = rigid::Reduction::new(set, &constraints)?;
///             let free = nalgebra::DVector::zeros(reduction.dofs());
///             let motion = set.state_velocity(reduction.velocities(&free)?.as_slice())?;
///             let bodies = vec![BodySolution::default(); 2];
///             Ok(InstantaneousSolution::new(bodies, vec![Default::default()], motion))
///         };
///         query.rates.iter().map(one).collect()
///     }
/// }
///
/// let scene = Scene::parse(
///     r#"
///     bodies = [
///         { name = "anchor", radius = 100, position = [0, 0, 0] },
///         { name = "head", radius = 1, position = [110, 0, 0] },
///     ]
///     links = [{ name = "neck", body = "head", to = "anchor" }]
///     gait.phases = [{ link = "neck", length = 105 }]
///     "#,
/// )?;
/// // `choose(&scene)?.model` gives one of the models of this workspace.
/// let mut model = Anchor(scene.clone());
/// let outcome = simulate(&scene, &mut model, Method::Collocation, &mut ())?;
/// assert!((outcome.displacement[1].x + 5.0).abs() < 1e-12);
/// # Ok::<(), swimmer::SwimError>(())
/// ```
pub fn simulate(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    method: Method,
    observer: &mut dyn Observer,
) -> Result<Outcome, SwimError> {
    scene.require_gait()?;
    let start = start_of_gait(scene, model, method, &mut ())?;
    continue_from(scene, model, method, observer, start)
}

/// Moves the bodies through the remaining phase spans of an interrupted run.
///
/// If the history of the model has been restored, the result is bitwise that of a run without
/// interruption.
///
/// # Errors
/// As [`simulate`].
pub fn continue_from(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    method: Method,
    observer: &mut dyn Observer,
    mut interim: Interim,
) -> Result<Outcome, SwimError> {
    check_model(scene, model)?;
    method.check(scene)?;
    scene.require_gait()?;
    let origin = match interim.outcome.curve.first() {
        Some((_, origin)) => origin.clone(),
        None => interim.positions(scene, scene.articulation().initial_shape())?,
    };
    let unsteady = match method {
        Method::Unsteady => UnsteadyScene::new(scene)?,
        _ => None,
    };
    let mut integrator = Integrator::new(scene, model, method)
        .with_velocities(&interim.outcome.velocities)
        .with_flows(observer.wants_flows());
    if let Some(unsteady) = &unsteady {
        integrator = integrator.with_unsteady_scene(unsteady)?;
    }
    let mut remaining = spans(scene.gait(), scene.articulation().initial_shape())?;
    // Up to the last completed one.
    let done = interim.outcome.spans.len().checked_sub(1);
    let last = match (done, interim.outcome.periodic_start) {
        (Some(done), _) => remaining.nth(done),
        (None, Some(_)) => span_before(scene)?,
        (None, None) => None,
    };
    if let (Some(last), Some(_)) = (last, &unsteady) {
        let fluid = interim.fluid.take();
        let fluid = fluid.ok_or_else(|| not_continued(&SwimError::NoFlow))?;
        integrator = (integrator.after(&last, fluid)).map_err(|error| not_continued(&error))?;
    }
    for span in remaining {
        let first = interim.outcome.solves;
        let meshes = &mut interim.outcome.meshes;
        let result = integrator.span(&span, &interim.state, &mut |solution, model| {
            if let Some(reason) = &solution.solution.remeshed {
                meshes.push(NewMesh {
                    time: span.time(solution.s),
                    phase: span.number + 1,
                    reason: reason.to_string(),
                });
            }
            let numbered = SpanSolution {
                number: first + solution.number,
                ..solution.clone()
            };
            observer.solved(&span, &numbered, model)
        });
        let result = match result {
            Err(error) => {
                let part = integrator.take_so_far();
                // Nothing has moved if the first step of all fails.
                let moved = |part: &SpanResult| span.number > 0 || part.reached() > 0.0;
                if let Some(part) = part.filter(moved) {
                    interim.append(scene, &origin, &span, &part)?;
                    let mut outcome = interim.outcome;
                    outcome.stopped = Some(error.to_string());
                    let controls_error = integrator.model().capabilities().controls_error;
                    outcome.check_tolerance(scene, controls_error);
                    observer.stopped(&span, &part, &outcome, integrator.model())?;
                }
                return Err(error);
            }
            Ok(result) => result,
        };
        interim.append(scene, &origin, &span, &result)?;
        observer.span_done(&span, &result, &interim.outcome, integrator.model())?;
    }
    let mut outcome = interim.outcome;
    let controls_error = integrator.model().capabilities().controls_error;
    outcome.check_tolerance(scene, controls_error);
    Ok(outcome)
}

/// The last phase span of a cycle, before the time zero.
fn span_before(scene: &Scene) -> Result<Option<PhaseSpan>, SwimError> {
    let gait = scene.gait();
    let cycle = spans(gait, scene.articulation().initial_shape())?.take(gait.phases.len());
    let mut last = cycle.last();
    if let Some(span) = &mut last {
        span.start -= gait.cycle_duration();
    }
    Ok(last)
}

/// The error for a fluid of a checkpoint that does not fit its scene.
fn not_continued(error: &SwimError) -> SwimError {
    SwimError::Checkpoint {
        path: checkpoint::FILE.into(),
        problem: format!("is damaged: the flow of its fluid does not fit: {error}"),
    }
}
