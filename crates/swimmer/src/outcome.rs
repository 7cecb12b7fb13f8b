//! The outcome of a gait.

use models::{AccumulatedError, BodySolution, ErrorEstimate, Hydrodynamics, NewMesh, Seconds};
use nalgebra::{Isometry3, Vector3};
use rigid::{Articulation, State};
use scene::Scene;
use serde::{Deserialize, Serialize};

use crate::error::SwimError;

/// The state of a run between two phase spans.
#[derive(Clone, Debug)]
pub struct Interim {
    /// State of the bodies.
    pub state: State,
    /// Outcome of the completed phase spans.
    pub outcome: Outcome,
}

/// The outcome of a gait, in the scene's units.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[non_exhaustive]
pub struct Outcome {
    /// Displacement of every body, including points.
    pub displacement: Vec<Vector3<f64>>,
    /// Rotation vector of the frame of the first linkage.
    pub rotation: Vector3<f64>,
    /// Outcome of each phase span.
    pub spans: Vec<SpanOutcome>,
    /// Number of solves.
    pub solves: usize,
    /// Error bars of the displacements.
    pub error_estimate: ErrorEstimate,
    /// Estimated discretisation errors that were subtracted from the displacements, computed minus
    /// exact, one per body.
    pub mesh_error: Option<Vec<Vector3<f64>>>,
    /// Accumulated discretisation error of the phase spans so far; none where a phase span has no
    /// estimate.
    #[serde(rename = "drift")]
    pub accumulated_error: Option<AccumulatedError>,
    /// Accumulated integration error, for methods that estimate it with its sign.
    #[serde(default, rename = "integration_drift")]
    pub accumulated_integration_error: Option<AccumulatedError>,
    /// The error bar that `model.tolerance` limits, at the end of the gait; none if the integration
    /// error is not estimated.
    ///
    /// It is the sum of all error bars for a model that controls its own error
    /// ([`models::Hydrodynamics::controls_error`]), and that of the integration for other models.
    #[serde(default)]
    pub limited_error: Option<f64>,
    /// Largest value of `limited_error` that meets the tolerance: `model.tolerance` times a length.
    ///
    /// The length is [`Outcome::reference_displacement`]; with slip or a background flow it is at
    /// least the longest arc that a point of a surface covers.
    #[serde(default)]
    pub allowed_error: f64,
    /// Whether `limited_error` is at most `allowed_error`.
    pub tolerance_met: bool,
    /// Work of the bodies on the fluid.
    pub work: f64,
    /// Error bars of the work.
    #[serde(default)]
    pub work_error: ErrorEstimate,
    /// Velocities `(U, ω)` of all bodies at the end, six per body; empty without masses.
    #[serde(default)]
    pub velocities: Vec<f64>,
    /// Seconds of all solves, added up also where they ran at the same time.
    pub seconds: Seconds,
    /// The meshes that were generated, for models with a mesh.
    #[serde(default)]
    pub meshes: Vec<NewMesh>,
    /// The trajectory at the ends of phase spans and at the solves, in the order of time.
    pub samples: Vec<Sample>,
    /// The trajectory between the samples, for plots: times and positions of all bodies.
    pub curve: Vec<(f64, Vec<Vector3<f64>>)>,
}

impl Outcome {
    /// The net displacement: the distance that the mean of the centres of the moving bodies covers.
    ///
    /// A rotation about that mean is no displacement. Fixed bodies do not count.
    pub fn net(&self) -> f64 {
        mean_of_moving(&self.displacement).norm()
    }

    /// The work without the correction of its discretisation error.
    pub fn uncorrected_work(&self) -> f64 {
        self.work
            + self
                .accumulated_error
                .as_ref()
                .map_or(0.0, |error| error.work)
    }

    /// The displacement to which `model.tolerance` is relative: the net displacement.
    ///
    /// If the net displacement cannot be distinguished from zero, as for reciprocal gaits, it is
    /// the longest displacement of a body in one phase.
    pub fn reference_displacement(&self) -> f64 {
        let net = self.net();
        match net > self.error_estimate.total() {
            true => net,
            false => {
                let spans = self.spans.iter().flat_map(|span| &span.displacement);
                spans.fold(net, |longest, d| longest.max(d.norm()))
            }
        }
    }

    /// Largest distance that a point of a surface covers by the rotation of its body.
    fn longest_arc(&self, scene: &Scene) -> f64 {
        let turned = |body: usize| -> f64 {
            let pairs = self.samples.windows(2);
            let rotations = pairs.map(|pair| [0, 1].map(|k| pair[k].poses[body].rotation));
            rotations
                .map(|[before, after]| before.angle_to(&after))
                .sum()
        };
        let arcs = scene.bodies().iter().enumerate();
        arcs.map(|(number, body)| turned(number) * body.bounding_radius())
            .fold(0.0, f64::max)
    }

    /// Compares the error bar that a tolerance limits with it, at the end of the gait.
    pub(crate) fn check_tolerance(&mut self, tolerance: f64, model: &dyn Hydrodynamics) {
        let bars = &self.error_estimate;
        self.limited_error = bars.integration.map(|error| match model.controls_error() {
            true => bars.total(),
            false => error,
        });
        let scene = model.scene();
        let reference = match scene.has_surface_velocity() {
            // Bodies may tumble in place.
            true => self.reference_displacement().max(self.longest_arc(scene)),
            false => self.reference_displacement(),
        };
        self.allowed_error = tolerance * reference;
        // Methods without an error estimate do not meet a tolerance.
        let limited = self.limited_error;
        self.tolerance_met = limited.is_some_and(|error| error <= self.allowed_error);
    }
}

/// The mean of the nonzero displacements; only those of fixed bodies are exactly zero.
pub(crate) fn mean_of_moving(displacement: &[Vector3<f64>]) -> Vector3<f64> {
    let moving = displacement.iter().filter(|d| **d != Vector3::zeros());
    let count = moving.clone().count().max(1);
    moving.sum::<Vector3<f64>>() / count as f64
}

/// The outcome of one phase span.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[non_exhaustive]
pub struct SpanOutcome {
    /// The joints that changed their values.
    pub joints: Vec<usize>,
    /// Displacement of every body.
    pub displacement: Vec<Vector3<f64>>,
    /// Number of solves.
    pub solves: usize,
    /// Error bars of the displacements.
    pub error_estimate: ErrorEstimate,
}

/// One point of the trajectory.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[non_exhaustive]
pub struct Sample {
    /// Time.
    pub time: f64,
    /// Number of the phase span from zero, over all cycles.
    pub span: usize,
    /// Values of the joints.
    pub shape: Vec<f64>,
    /// Pose of every body.
    pub poses: Vec<Isometry3<f64>>,
    /// Velocities and forces at a solve; none at the ends of phase spans.
    pub bodies: Option<Vec<BodySolution>>,
}

impl Interim {
    /// The state before the first phase span.
    ///
    /// # Errors
    /// A linkage whose loop the initial shape does not close.
    pub fn start(scene: &Scene) -> Result<Self, SwimError> {
        Self::from_state(scene, scene.initial_state())
    }

    /// A state before the first phase span, such as one with other values of passive joints.
    ///
    /// # Errors
    /// A state of another articulation, or one in which a loop does not close.
    pub fn from_state(scene: &Scene, state: State) -> Result<Self, SwimError> {
        let set = scene.articulation();
        let shape = set.initial_shape();
        let origin = positions(set, &state, shape)?;
        let outcome = Outcome {
            displacement: vec![Vector3::zeros(); origin.len()],
            rotation: Vector3::zeros(),
            spans: Vec::new(),
            solves: 0,
            error_estimate: ErrorEstimate::default(),
            mesh_error: None,
            accumulated_error: Some(AccumulatedError::default()),
            accumulated_integration_error: Some(AccumulatedError::default()),
            limited_error: None,
            allowed_error: 0.0,
            tolerance_met: true,
            work: 0.0,
            work_error: ErrorEstimate::default(),
            velocities: Vec::new(),
            seconds: Seconds::default(),
            meshes: Vec::new(),
            samples: vec![Sample {
                time: 0.0,
                span: 0,
                shape: set.joint_values(&state, shape)?,
                poses: set.place(&state, shape)?,
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
    shape: &[f64],
) -> Result<Vec<Vector3<f64>>, SwimError> {
    Ok(set
        .place(state, shape)?
        .iter()
        .map(|pose| pose.translation.vector)
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_bodies_do_not_dilute_the_net_displacement() {
        let [fixed, moving] = [Vector3::zeros(), Vector3::new(3.0, 4.0, 0.0)];
        assert_eq!(mean_of_moving(&[moving, fixed, moving]), moving);
        assert_eq!(mean_of_moving(&[fixed]), fixed);
    }
}
