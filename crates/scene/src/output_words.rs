//! Words of the keys that say what a run writes.

use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantNames};

crate::words::words!(FlowsKind);

/// Flows that a run by elements in space writes for ParaView.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr, VariantNames,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
pub enum FlowsKind {
    /// The last flow that is solved in each phase.
    #[default]
    Phase,
    /// All flows of the trajectory.
    All,
    /// None.
    Off,
}
