//! Simulation of a whole gait.

use models::{AccumulatedError, ErrorEstimate, Hydrodynamics, NewMesh};
use nalgebra::Vector3;
use rigid::Articulation;
use scene::{Scene, spans};

use crate::error::SwimError;
use crate::integrate::{Integrator, Method, SpanSolution};
use crate::observer::Observer;
use crate::outcome::{Interim, Outcome, Sample, SpanOutcome, positions};
use crate::periodic::start_of_gait;

/// Points of the curve per piece of a phase span: enough for a smooth plot.
const CURVE_POINTS: usize = 12;

/// Moves the bodies of a scene through all cycles of its gait, from the periodic state if the scene
/// says so ([`start_of_gait`]).
///
/// The observer sees the gait, not the search for the periodic state.
///
/// # Errors
/// A scene without a gait; [`SwimError::OtherScene`] for a model of another scene;
/// [`SwimError::NoSteps`]; [`SwimError::NotPeriodic`]; errors of the model, the integration and the
/// observer.
///
/// # Examples
/// A model outside this workspace:
///
/// ```
/// use swimmer::models::{
///     BodySolution, Configuration, Cost, Hydrodynamics, InstantaneousSolution, ModelError, Query,
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
///
///     fn cost(&mut self, _: Configuration) -> Result<Cost, ModelError> {
///         Ok(Cost::default())
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
    let start = start_of_gait(scene, model, method, &mut |_, _| Ok(()))?;
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
    Interim {
        mut state,
        mut outcome,
    }: Interim,
) -> Result<Outcome, SwimError> {
    check_model(scene, model)?;
    method.check()?;
    scene.require_gait()?;
    let set = scene.articulation();
    let start = scene.initial_state();
    let initial_shape = set.initial_shape();
    let origin = match outcome.curve.first() {
        Some((_, origin)) => origin.clone(),
        None => positions(set, &state, initial_shape)?,
    };
    let mut integrator = Integrator::new(scene, model, method).with_velocities(&outcome.velocities);
    for span in spans(scene.gait(), initial_shape)?.skip(outcome.spans.len()) {
        let before = positions(set, &state, &span.from)?;
        let first = outcome.solves;
        let meshes = &mut outcome.meshes;
        let result = integrator.span(&span, &state, &mut |span_solution, model| {
            if let Some(reason) = &span_solution.solution.remeshed {
                meshes.push(NewMesh {
                    time: span.time(span_solution.s),
                    phase: span.number + 1,
                    reason: reason.to_string(),
                });
            }
            observer.solved(
                &span,
                &SpanSolution {
                    number: first + span_solution.number,
                    ..span_solution.clone()
                },
                model,
            )
        })?;
        for span_solution in &result.solutions {
            let shape = span.shape(span_solution.s);
            let state = result.state(set, span_solution.s)?;
            outcome.samples.push(Sample {
                time: span.time(span_solution.s),
                span: span.number,
                poses: set.place(&state, &shape)?,
                shape: set.joint_values(&state, &shape)?,
                bodies: Some(span_solution.solution.bodies.clone()),
            });
        }
        let parts = CURVE_POINTS * result.pieces.len();
        for k in 1..=parts {
            let s = k as f64 / parts as f64;
            outcome.curve.push((
                span.time(s),
                positions(set, &result.state(set, s)?, &span.shape(s))?,
            ));
        }
        state = result.end.clone();
        let after = positions(set, &state, &span.to)?;
        outcome.samples.push(Sample {
            time: span.time(1.0),
            span: span.number,
            shape: set.joint_values(&state, &span.to)?,
            poses: set.place(&state, &span.to)?,
            bodies: None,
        });
        let displacement: Vec<_> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        let body_errors = |error: &AccumulatedError| -> Vec<Vector3<f64>> {
            errors_of_bodies(set, error, &after)
        };
        let largest = |error: &AccumulatedError| {
            let errors = body_errors(error);
            errors.iter().fold(0.0_f64, |m, e| m.max(e.norm()))
        };
        // Errors of the integration are bars, those of the mesh were subtracted.
        let error_bar = |error: &AccumulatedError| largest(error).hypot(error.uncertainty);
        let corrected_bar = |error: &AccumulatedError| error.displacement_error_bar(largest(error));
        let (mesh_error, integration_error) = (
            result.accumulated_error.as_ref(),
            result.accumulated_integration_error.as_ref(),
        );
        outcome.spans.push(SpanOutcome {
            joints: span.joints.clone(),
            solves: result.solves,
            error_estimate: ErrorEstimate {
                mesh: mesh_error.map(corrected_bar),
                integration: integration_error
                    .map(error_bar)
                    .or(result.error_estimate.integration),
                ..result.error_estimate
            },
            displacement: displacement.clone(),
        });
        let root_displacement: Vec<_> = set
            .linkages()
            .iter()
            .map(|l| displacement[l.root])
            .collect();
        let appended = |sum: Option<AccumulatedError>, span: Option<&AccumulatedError>| {
            let (mut sum, span) = sum.zip(span)?;
            sum.append(span, &root_displacement);
            Some(sum)
        };
        outcome.accumulated_error = appended(outcome.accumulated_error.take(), mesh_error);
        outcome.accumulated_integration_error = appended(
            outcome.accumulated_integration_error.take(),
            integration_error,
        );
        outcome.displacement = after.iter().zip(&origin).map(|(a, b)| a - b).collect();
        outcome.rotation =
            (state.frames[0].rotation * start.frames[0].rotation.inverse()).scaled_axis();
        outcome.solves += result.solves;
        outcome
            .error_estimate
            .accumulate(1.0, &result.error_estimate);
        outcome.mesh_error = outcome.accumulated_error.as_ref().map(body_errors);
        let accumulated = outcome.accumulated_error.as_ref();
        outcome.error_estimate.mesh = accumulated.map(corrected_bar);
        if let Some(error) = &outcome.accumulated_integration_error {
            outcome.error_estimate.integration = Some(error_bar(error));
        }
        outcome.velocities.clone_from(&result.velocities);
        outcome.work += result.work;
        outcome.work_error.accumulate(1.0, &result.work_error);
        outcome.work_error.mesh = accumulated.map(AccumulatedError::work_error_bar);
        outcome.seconds += result.seconds;
        observer.span_done(&span, &result, &outcome, integrator.model())?;
    }
    outcome.check_tolerance(scene.model().tolerance, integrator.model());
    Ok(outcome)
}

/// Refuses a model that was created for another flow problem.
///
/// # Errors
/// [`SwimError::OtherScene`].
pub(crate) fn check_model(scene: &Scene, model: &dyn Hydrodynamics) -> Result<(), SwimError> {
    match scene.differing_key(model.scene()) {
        Some(key) => Err(SwimError::OtherScene {
            model: model.name(),
            key,
        }),
        None => Ok(()),
    }
}

/// Errors of the displacements of the bodies, from the errors of the frames of their linkages.
fn errors_of_bodies(
    set: &Articulation,
    error: &AccumulatedError,
    positions: &[Vector3<f64>],
) -> Vec<Vector3<f64>> {
    let mut errors = vec![Vector3::zeros(); positions.len()];
    for (number, linkage) in set.linkages().iter().enumerate() {
        for &body in &linkage.bodies {
            errors[body] = error.of_body(number, &(positions[body] - positions[linkage.root]));
        }
    }
    errors
}
