//! What a gait did to the bodies.

use models::{AccumulatedError, BodySolution, ErrorEstimate, NewMesh, Seconds};
use nalgebra::{Isometry3, Vector3};
use rigid::{Articulation, State};
use scene::Scene;
use serde::{Deserialize, Serialize};

use crate::SwimError;

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
    /// Accumulated discretisation error of the legs so far; none where some leg was not estimated.
    #[serde(rename = "drift")]
    pub accumulated_error: Option<AccumulatedError>,
    /// The same for the integration, for methods that estimate signed errors.
    #[serde(default, rename = "integration_drift")]
    pub accumulated_integration_error: Option<AccumulatedError>,
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
    pub bodies: Option<Vec<BodySolution>>,
}

impl Interim {
    /// The start of a scene, nothing done.
    ///
    /// # Errors
    /// Lengths that do not close a loop.
    pub fn start(scene: &Scene) -> Result<Self, SwimError> {
        let set = scene.articulation();
        let state = scene.initial_state();
        let lengths = set.initial_lengths();
        let origin = positions(set, &state, lengths)?;
        let outcome = Outcome {
            displacement: vec![Vector3::zeros(); origin.len()],
            rotation: Vector3::zeros(),
            legs: Vec::new(),
            solves: 0,
            error_estimate: ErrorEstimate::default(),
            mesh_error: None,
            accumulated_error: Some(AccumulatedError::default()),
            accumulated_integration_error: Some(AccumulatedError::default()),
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

/// Positions of all bodies.
pub(crate) fn positions(
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
