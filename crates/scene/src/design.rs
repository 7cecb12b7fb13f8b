//! Options of the design of strokes: the groups `optimise` and `learn` of a scene file.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::design_words::{LearnKind, ObjectiveKind, StrokeStart};

/// Values of joints: one for all joints, one per joint, or some by the names of the joints.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum JointValues {
    /// The same value for all joints that the gait can prescribe.
    All(f64),
    /// One value per joint, in the order of the file.
    List(Vec<f64>),
    /// Values by the names of joints; other joints have none.
    Named(BTreeMap<String, f64>),
}

/// Options of `swim map`, `swim optimise` and `swim sizes`: the group `optimise` of a scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct OptimiseOptions {
    /// What is optimised.
    pub objective: ObjectiveKind,
    /// Whether the stroke passes through the shape of the scene.
    pub start: StrokeStart,
    /// Net displacement of a stroke with `objective = "energy"`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub displacement: Option<f64>,
    /// Rotation of a stroke with `objective = "rotation"`, in radians.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation: Option<f64>,
    /// Direction of the displacement; its length counts without a direction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<[f64; 3]>,
    /// Axis of the rotation.
    pub axis: [f64; 3],
    /// Smallest values of the joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lower: Option<JointValues>,
    /// Largest values of the joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub upper: Option<JointValues>,
    /// Smallest gap between bodies; none for a tenth of the smallest radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// Smallest and largest radius of the spheres whose sizes are optimised.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub radii: Option<[f64; 2]>,
    /// Smallest and largest length, at any time of the gait, of the arms whose lengths are
    /// optimised.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arms: Option<[f64; 2]>,
    /// Period of the stroke.
    pub period: f64,
    /// Mean power, which determines the period.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub power: Option<f64>,
    /// Largest rates of the joints, which determine the motion along the stroke.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_rate: Option<JointValues>,
    /// Largest power on the fluid, which determines the motion along the stroke.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_power: Option<f64>,
    /// Largest number of terms of the series of each joint.
    pub terms: u32,
    /// Relative change of the objective, with twice as many terms, at which refinement ends.
    pub tolerance: f64,
}

impl Default for OptimiseOptions {
    fn default() -> Self {
        Self {
            objective: ObjectiveKind::default(),
            start: StrokeStart::default(),
            displacement: None,
            rotation: None,
            direction: None,
            axis: [0.0, 0.0, 1.0],
            lower: None,
            upper: None,
            gap: None,
            radii: None,
            arms: None,
            period: 1.0,
            power: None,
            max_rate: None,
            max_power: None,
            // Strokes that touch their limits gain a factor of four to eight by doubling the
            // number of terms, and need this number for four digits.
            terms: 64,
            // The error that is left is a fraction of the last change: four digits.
            tolerance: 2e-4,
        }
    }
}

/// Options of `swim learn`: the group `learn` of a scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct LearnOptions {
    /// The method.
    pub method: LearnKind,
    /// Values of contracted joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contracted: Option<JointValues>,
    /// Values of extended joints; those of the start of the scene if they are absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub extended: Option<JointValues>,
    /// Direction in which a displacement is rewarded.
    pub direction: [f64; 3],
    /// Number of episodes.
    pub episodes: u32,
    /// Number of steps of an episode.
    pub steps: u32,
    /// Discount of a reward per step.
    pub discount: f64,
    /// Share of an update that replaces the old value.
    pub rate: f64,
    /// Probability of a random action.
    pub exploration: f64,
    /// Seed of the random numbers.
    pub seed: u32,
}

impl Default for LearnOptions {
    fn default() -> Self {
        Self {
            method: LearnKind::default(),
            contracted: None,
            extended: None,
            direction: [1.0, 0.0, 0.0],
            episodes: 100,
            steps: 100,
            // Far above 0.2748, below which three spheres do not learn to swim.
            discount: 0.9,
            // Rewards are not random, so that large updates converge.
            rate: 0.5,
            // Frequent random actions: every state must be visited often.
            exploration: 0.3,
            seed: 1,
        }
    }
}
