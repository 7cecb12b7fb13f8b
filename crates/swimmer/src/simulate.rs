//! A whole gait from start to end.

use nalgebra::{DMatrix, Isometry3, Vector3};
use rigid::{Articulation, State};
use serde::{Deserialize, Serialize};

use crate::SwimError;
use crate::integrate::{Integrator, LegResult, Method, Solved};
use crate::model::{
    BodyInstant, Drift, ErrorEstimate, Flow, Hydrodynamics, ModelError, NewMesh, Placement, Seconds,
};
use scene::Scene;
use scene::{Leg, legs};

/// What may be done while a simulation goes on: write files, show progress.
pub trait Observer {
    /// Sees every solve, with the model that made it; `number` counts over the whole simulation.
    ///
    /// # Errors
    /// Any error ends the simulation.
    fn solved(
        &mut self,
        leg: &Leg,
        solved: &Solved,
        model: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        let _ = (leg, solved, model);
        Ok(())
    }

    /// Sees every leg when it is done, everything up to it, and the model in whose hands the next leg is.
    ///
    /// # Errors
    /// Any error ends the simulation.
    fn leg_done(
        &mut self,
        leg: &Leg,
        result: &LegResult,
        so_far: &Outcome,
        model: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        let _ = (leg, result, so_far, model);
        Ok(())
    }
}

/// An observer that does nothing.
impl Observer for () {}

/// A run between two legs.
#[derive(Clone, Debug)]
pub struct Interim {
    /// Where the bodies are.
    pub state: State,
    /// What the legs so far did.
    pub outcome: Outcome,
}

/// What a gait did to the bodies, in the scene's units.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Outcome {
    /// Displacement of every body, points included.
    pub displacement: Vec<Vector3<f64>>,
    /// Rotation vector of the first linkage's frame.
    pub rotation: Vector3<f64>,
    /// What each leg did.
    pub legs: Vec<LegOutcome>,
    /// Number of solves.
    pub solves: usize,
    /// Error bars of the displacements.
    pub error_estimate: ErrorEstimate,
    /// Estimated errors of the displacements by the mesh, computed less exact, one a body: less these, displacements are better.
    pub mesh_error: Option<Vec<Vector3<f64>>>,
    /// What the mesh's errors of the legs so far add up to; none where some leg was not estimated.
    pub drift: Option<Drift>,
    /// The same of the integration's errors, for methods that know them with their signs.
    #[serde(default)]
    pub integration_drift: Option<Drift>,
    /// Whether every leg met its share of the tolerance, and the error of the integration is below the tolerance
    /// times the [`Outcome::net`] displacement.
    pub tolerance_met: bool,
    /// Work of the bodies on the fluid.
    pub work: f64,
    /// Seconds of all solves.
    pub seconds: Seconds,
    /// The meshes that were made, for models that have any.
    #[serde(default)]
    pub meshes: Vec<NewMesh>,
    /// The trajectory at the ends of legs and at the points solved, in time.
    pub samples: Vec<Sample>,
    /// The trajectory between them, for curves: times and positions of all bodies.
    pub curve: Vec<(f64, Vec<Vector3<f64>>)>,
}

impl Outcome {
    /// The net displacement: that of the mean of the bodies' centres, so that turning alone is none; fixed bodies do not count.
    pub fn net(&self) -> f64 {
        mean_of_moved(&self.displacement).norm()
    }
}

/// The mean of displacements without those that are zero to the last bit, as only those of fixed bodies are.
fn mean_of_moved(displacement: &[Vector3<f64>]) -> Vector3<f64> {
    let moved = displacement.iter().filter(|d| **d != Vector3::zeros());
    let count = moved.clone().count().max(1);
    moved.sum::<Vector3<f64>>() / count as f64
}

/// What one leg did.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct LegOutcome {
    /// The link that changed its length, if any.
    pub link: Option<usize>,
    /// Displacement of every body.
    pub displacement: Vec<Vector3<f64>>,
    /// Number of solves.
    pub solves: usize,
    /// Error bars of the displacements.
    pub error_estimate: ErrorEstimate,
}

/// One point of the trajectory.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Sample {
    /// Time.
    pub time: f64,
    /// Number of the leg from zero, over all cycles.
    pub leg: usize,
    /// Lengths of the links.
    pub lengths: Vec<f64>,
    /// Pose of every body.
    pub poses: Vec<Isometry3<f64>>,
    /// Velocities and forces where the model was asked; none at the ends of legs.
    pub bodies: Option<Vec<BodyInstant>>,
}

/// Points of the curve within each piece of a leg: enough for a picture to look smooth.
const CURVE_POINTS: usize = 12;

impl Interim {
    /// The start of a scene, nothing done.
    ///
    /// # Errors
    /// Lengths that do not close a loop.
    pub fn start(scene: &Scene) -> Result<Self, SwimError> {
        let set = &scene.articulation;
        let state = scene.initial_state();
        let lengths = set.initial_lengths();
        let origin = places(set, &state, lengths)?;
        let outcome = Outcome {
            displacement: vec![Vector3::zeros(); origin.len()],
            rotation: Vector3::zeros(),
            legs: Vec::new(),
            solves: 0,
            error_estimate: ErrorEstimate::default(),
            mesh_error: None,
            drift: Some(Drift::default()),
            integration_drift: Some(Drift::default()),
            tolerance_met: true,
            work: 0.0,
            seconds: Seconds::default(),
            meshes: Vec::new(),
            samples: vec![Sample {
                time: 0.0,
                leg: 0,
                lengths: lengths.to_vec(),
                poses: set.place(&state, lengths)?,
                bodies: None,
            }],
            curve: vec![(0.0, origin)],
        };
        Ok(Self { state, outcome })
    }
}

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
    go_on(scene, model, method, observer, Interim::start(scene)?)
}

fn places(
    set: &Articulation,
    state: &State,
    lengths: &[f64],
) -> Result<Vec<Vector3<f64>>, SwimError> {
    Ok(set
        .place(state, lengths)?
        .iter()
        .map(|pose| pose.translation.vector)
        .collect())
}

/// Moves the bodies through the legs that an earlier run left, to the same end bit for bit if the model has its history back.
///
/// # Errors
/// As [`simulate`].
pub fn go_on(
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
    let set = &scene.articulation;
    let start = scene.initial_state();
    let initial_lengths = set.initial_lengths();
    let origin = places(set, &start, initial_lengths)?;
    let mut integrator = Integrator::new(scene, model, method);
    for leg in legs(&scene.gait, initial_lengths).skip(outcome.legs.len()) {
        let before = places(set, &state, &leg.from)?;
        let first = outcome.solves;
        let meshes = &mut outcome.meshes;
        let result = integrator.leg(&leg, &state, &mut |solved, model| {
            if let Some(reason) = solved.instant.remeshed {
                meshes.push(NewMesh {
                    time: leg.time(solved.s),
                    phase: leg.number + 1,
                    reason: reason.to_string(),
                });
            }
            observer.solved(
                &leg,
                &Solved {
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
                bodies: Some(solved.instant.bodies.clone()),
            });
        }
        let parts = CURVE_POINTS * result.pieces.len();
        for k in 1..=parts {
            let s = k as f64 / parts as f64;
            outcome.curve.push((
                leg.time(s),
                places(set, &result.state(set, s)?, &leg.lengths(s))?,
            ));
        }
        state = result.end.clone();
        let after = places(set, &state, &leg.to)?;
        outcome.samples.push(Sample {
            time: leg.time(1.0),
            leg: leg.number,
            lengths: leg.to.clone(),
            poses: set.place(&state, &leg.to)?,
            bodies: None,
        });
        let displacement: Vec<_> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        let of_bodies =
            |drift: &Drift| -> Vec<Vector3<f64>> { errors_of_bodies(set, drift, &after) };
        let bar = |drift: &Drift| {
            of_bodies(drift)
                .iter()
                .fold(0.0_f64, |m, e| m.max(e.norm()))
                .hypot(drift.uncertainty)
        };
        let (by_mesh, by_steps) = (result.drift.as_ref(), result.integration_drift.as_ref());
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
        let appended = |sum: Option<Drift>, own: Option<&Drift>| {
            let (mut sum, own) = sum.zip(own)?;
            sum.append(own, &moved);
            Some(sum)
        };
        outcome.drift = appended(outcome.drift.take(), by_mesh);
        outcome.integration_drift = appended(outcome.integration_drift.take(), by_steps);
        outcome.displacement = after.iter().zip(&origin).map(|(a, b)| a - b).collect();
        outcome.rotation =
            (state.frames[0].rotation * start.frames[0].rotation.inverse()).scaled_axis();
        outcome.solves += result.solves;
        outcome
            .error_estimate
            .accumulate(1.0, &result.error_estimate);
        outcome.mesh_error = outcome.drift.as_ref().map(of_bodies);
        outcome.error_estimate.mesh = outcome.drift.as_ref().map(bar);
        if let Some(drift) = &outcome.integration_drift {
            outcome.error_estimate.integration = Some(bar(drift));
        }
        outcome.tolerance_met &= result.tolerance_met;
        outcome.work += result.work;
        outcome.seconds += result.seconds;
        observer.leg_done(&leg, &result, &outcome, integrator.model())?;
    }
    // Methods that do not estimate their error meet no tolerance.
    let bar = outcome.error_estimate.integration;
    outcome.tolerance_met &= bar.is_some_and(|bar| bar <= scene.model.tolerance * outcome.net());
    Ok(outcome)
}

/// Errors of the bodies' displacements for those of the frames.
fn errors_of_bodies(
    set: &Articulation,
    drift: &Drift,
    places: &[Vector3<f64>],
) -> Vec<Vector3<f64>> {
    let mut errors = vec![Vector3::zeros(); places.len()];
    for (number, linkage) in set.linkages().iter().enumerate() {
        for &body in &linkage.bodies {
            errors[body] = drift.of_body(number, &(places[body] - places[linkage.root]));
        }
    }
    errors
}

/// Asks the model for the instant at the start of the gait's first phase, or at rest if the scene has no gait; with the error by the
/// mesh that `fem.target` asks for, if the scene has one.
///
/// # Errors
/// What the model fails with.
pub fn solve_start(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
) -> Result<crate::model::Instant, SwimError> {
    let instant = at_start(scene, |placement| match scene.fem.target {
        None => model.instant(placement),
        Some(target) => model.instant_within(placement, target),
    })?;
    instant.check_finite(model.name())?;
    Ok(instant)
}

/// Asks the model for the grand resistance of the bodies where the scene starts.
///
/// # Errors
/// What the model fails with.
pub fn start_resistance(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
) -> Result<DMatrix<f64>, SwimError> {
    Ok(at_start(scene, |placement| model.resistance(placement))?)
}

/// The flow where the scene starts, for pictures.
///
/// # Errors
/// What the model fails with.
pub fn start_picture(scene: &Scene, model: &mut dyn Hydrodynamics) -> Result<Flow, SwimError> {
    Ok(at_start(scene, |placement| model.picture(placement))?)
}

/// Asks something about the placement at the start.
fn at_start<T>(
    scene: &Scene,
    ask: impl FnOnce(&Placement<'_>) -> Result<T, ModelError>,
) -> Result<T, ModelError> {
    let lengths = scene.articulation.initial_lengths();
    let rates = legs(&scene.gait, lengths)
        .next()
        .map_or(vec![0.0; lengths.len()], |leg| leg.rates());
    let state = scene.initial_state();
    ask(&Placement {
        state: &state,
        lengths,
        rates: &rates,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_bodies_do_not_dilute_the_net_displacement() {
        let [still, moved] = [Vector3::zeros(), Vector3::new(3.0, 4.0, 0.0)];
        assert_eq!(mean_of_moved(&[moved, still, moved]), moved);
        assert_eq!(mean_of_moved(&[still]), still);
    }
}
