//! Words of the groups `optimise` and `learn`, and their meanings.

use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantNames};

crate::words::words!(ObjectiveKind, StrokeStart, LearnKind);

/// What `swim optimise` optimises.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum ObjectiveKind {
    /// Lighthill efficiency.
    #[default]
    Efficiency,
    /// Largest displacement.
    Displacement,
    /// Least energy for a displacement.
    Energy,
    /// Least energy for a rotation.
    Rotation,
    /// Largest displacement per time within bounds on rates and power.
    Speed,
}

/// Where an optimal stroke starts.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum StrokeStart {
    /// Anywhere: a smooth closed curve of shapes.
    #[default]
    Closed,
    /// At the shape of the scene, where the curve may have a corner.
    Fixed,
}

/// Method of `swim learn`.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum LearnKind {
    /// Q-learning (Watkins & Dayan 1992).
    #[default]
    Q,
    /// Double Q-learning (van Hasselt 2010).
    DoubleQ,
}
