//! Points of the trajectory.

use models::BodySolution;
use nalgebra::Isometry3;
use scene::{PhaseSpan, Scene};
use serde::{Deserialize, Serialize};

use crate::added_mass::AddedMassForces;
use crate::kinetic_energy::KineticEnergy;
use crate::motion::TIME_ROUNDING;
use crate::turning::Turning;

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
    /// Rotation of every body since the start.
    #[serde(default)]
    pub turnings: Vec<Turning>,
    /// Velocities and forces, if they were solved for at this time; none at the ends of phase
    /// spans.
    pub bodies: Option<Vec<BodySolution>>,
    /// Velocities and forces where nothing was solved, at the start and at the ends of phase spans:
    /// those of the polynomial through the solves of the step before
    /// ([`SpanResult::bodies`](crate::SpanResult::bodies)), at the start of the first step after.
    /// None where a phase span has no solves, and at the start where fluid or bodies have inertia.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interpolated: Option<Vec<BodySolution>>,
    /// Kinetic energy of fluid and bodies, for fluids with inertia; none at equal intervals of
    /// time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kinetic_energy: Option<KineticEnergy>,
    /// Forces that accelerate the fluid, as the kinetic energy; in the meridian plane at every
    /// second step.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub added_mass: Option<AddedMassForces>,
}

impl Sample {
    /// Whether the model was solved at this time: at no time that the scene asks for at equal
    /// intervals, where all numbers are interpolated.
    pub fn is_solved(&self, scene: &Scene) -> bool {
        self.bodies.is_some() && scene.output().samples.is_none()
    }

    /// Velocities and forces of the bodies: solved for or, where nothing is solved, interpolated.
    pub fn loads(&self) -> Option<&[BodySolution]> {
        self.bodies.as_deref().or(self.interpolated.as_deref())
    }
}

/// Positions on a phase span, up to `reached`, of the times at equal intervals that follow the
/// first `known` ones; none unless the scene asks for them.
pub(super) fn uniform_times(
    scene: &Scene,
    span: &PhaseSpan,
    known: usize,
    reached: f64,
) -> Vec<f64> {
    let Some(intervals) = scene.output().samples else {
        return Vec::new();
    };
    let step = scene.gait().duration() / f64::from(intervals);
    let position = |number: usize| (number as f64 * step - span.start) / span.duration;
    (known..=intervals as usize)
        .map(position)
        .take_while(|s| *s <= reached + TIME_ROUNDING)
        .map(|s| s.clamp(0.0, reached))
        .collect()
}
