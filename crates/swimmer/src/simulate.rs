//! A whole gait from start to end.

use models::{AccumulatedError, ErrorEstimate, Hydrodynamics, NewMesh};
use nalgebra::Vector3;
use rigid::Articulation;
use scene::{Scene, legs};

use crate::SwimError;
use crate::integrate::{Integrator, LegSolution, Method};
use crate::observer::Observer;
use crate::outcome::{Interim, LegOutcome, Outcome, Sample, positions};

/// Points of the curve within each piece of a leg: enough for a picture to look smooth.
const CURVE_POINTS: usize = 12;

/// Moves the bodies of a scene through all cycles of its gait.
///
/// # Errors
/// A scene without gait; what the model, the integration and the observer fail with.
pub fn simulate(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    method: Method,
    observer: &mut dyn Observer,
) -> Result<Outcome, SwimError> {
    continue_from(scene, model, method, observer, Interim::start(scene)?)
}

/// Moves the bodies through the legs that an earlier run left, to the same end bit for bit if the model has its history back.
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
    scene.require_gait()?;
    let set = scene.articulation();
    let start = scene.initial_state();
    let initial_lengths = set.initial_lengths();
    let origin = positions(set, &start, initial_lengths)?;
    let mut integrator = Integrator::new(scene, model, method);
    for leg in legs(scene.gait(), initial_lengths).skip(outcome.legs.len()) {
        let before = positions(set, &state, &leg.from)?;
        let first = outcome.solves;
        let meshes = &mut outcome.meshes;
        let result = integrator.leg(&leg, &state, &mut |solved, model| {
            if let Some(reason) = solved.solution.remeshed {
                meshes.push(NewMesh {
                    time: leg.time(solved.s),
                    phase: leg.number + 1,
                    reason: reason.to_string(),
                });
            }
            observer.solved(
                &leg,
                &LegSolution {
                    number: first + solved.number,
                    ..solved.clone()
                },
                model,
            )
        })?;
        for solved in &result.solved {
            let lengths = leg.lengths(solved.s);
            outcome.samples.push(Sample {
                time: leg.time(solved.s),
                leg: leg.number,
                poses: set.place(&result.state(set, solved.s)?, &lengths)?,
                lengths,
                bodies: Some(solved.solution.bodies.clone()),
            });
        }
        let parts = CURVE_POINTS * result.pieces.len();
        for k in 1..=parts {
            let s = k as f64 / parts as f64;
            outcome.curve.push((
                leg.time(s),
                positions(set, &result.state(set, s)?, &leg.lengths(s))?,
            ));
        }
        state = result.end.clone();
        let after = positions(set, &state, &leg.to)?;
        outcome.samples.push(Sample {
            time: leg.time(1.0),
            leg: leg.number,
            lengths: leg.to.clone(),
            poses: set.place(&state, &leg.to)?,
            bodies: None,
        });
        let displacement: Vec<_> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        let of_bodies = |error: &AccumulatedError| -> Vec<Vector3<f64>> {
            errors_of_bodies(set, error, &after)
        };
        let bar = |error: &AccumulatedError| {
            of_bodies(error)
                .iter()
                .fold(0.0_f64, |m, e| m.max(e.norm()))
                .hypot(error.uncertainty)
        };
        let (by_mesh, by_steps) = (
            result.accumulated_error.as_ref(),
            result.accumulated_integration_error.as_ref(),
        );
        outcome.legs.push(LegOutcome {
            link: leg.link,
            solves: result.solves,
            error_estimate: ErrorEstimate {
                mesh: by_mesh.map(bar),
                integration: by_steps.map(bar).or(result.error_estimate.integration),
                ..result.error_estimate
            },
            displacement: displacement.clone(),
        });
        let moved: Vec<_> = set
            .linkages()
            .iter()
            .map(|l| displacement[l.root])
            .collect();
        let appended = |sum: Option<AccumulatedError>, own: Option<&AccumulatedError>| {
            let (mut sum, own) = sum.zip(own)?;
            sum.append(own, &moved);
            Some(sum)
        };
        outcome.accumulated_error = appended(outcome.accumulated_error.take(), by_mesh);
        outcome.accumulated_integration_error =
            appended(outcome.accumulated_integration_error.take(), by_steps);
        outcome.displacement = after.iter().zip(&origin).map(|(a, b)| a - b).collect();
        outcome.rotation =
            (state.frames[0].rotation * start.frames[0].rotation.inverse()).scaled_axis();
        outcome.solves += result.solves;
        outcome
            .error_estimate
            .accumulate(1.0, &result.error_estimate);
        outcome.mesh_error = outcome.accumulated_error.as_ref().map(of_bodies);
        outcome.error_estimate.mesh = outcome.accumulated_error.as_ref().map(bar);
        if let Some(error) = &outcome.accumulated_integration_error {
            outcome.error_estimate.integration = Some(bar(error));
        }
        outcome.tolerance_met &= result.tolerance_met;
        outcome.work += result.work;
        outcome.seconds += result.seconds;
        observer.leg_done(&leg, &result, &outcome, integrator.model())?;
    }
    // Methods that do not estimate their error meet no tolerance.
    let bar = outcome.error_estimate.integration;
    outcome.tolerance_met &= bar.is_some_and(|bar| bar <= scene.model().tolerance * outcome.net());
    Ok(outcome)
}

/// Errors of the bodies' displacements for those of the frames.
fn errors_of_bodies(
    set: &Articulation,
    error: &AccumulatedError,
    places: &[Vector3<f64>],
) -> Vec<Vector3<f64>> {
    let mut errors = vec![Vector3::zeros(); places.len()];
    for (number, linkage) in set.linkages().iter().enumerate() {
        for &body in &linkage.bodies {
            errors[body] = error.of_body(number, &(places[body] - places[linkage.root]));
        }
    }
    errors
}
