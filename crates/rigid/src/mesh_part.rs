//! A fluid that is divided between processes.

use std::fmt;
use std::sync::Arc;

/// Replaces numbers of this process by their sums over all processes.
///
/// It is called by every process in the same order with equally many numbers, on the thread that
/// calls this crate. A sum that fails writes NaN, which later checks refuse.
pub type SumOverParts = Arc<dyn Fn(&mut [f64]) + Send + Sync>;

/// The nodes of a mesh whose equations belong to this process.
///
/// Each process passes the matrices of its part: all cells around the nodes that it owns, so that
/// the rows of these nodes are complete. The other nodes of these cells are owned by other
/// processes; their rows are incomplete and are not used. Every node of the whole mesh has one
/// owner. All that belongs to bodies and links is the same on every process.
#[derive(Clone)]
pub struct MeshPart {
    owned: Vec<bool>,
    sum: SumOverParts,
}

impl MeshPart {
    /// A part that owns the nodes with `owned`, one flag per node of the part.
    pub fn new(owned: Vec<bool>, sum: SumOverParts) -> Self {
        Self { owned, sum }
    }

    /// Whether the node is owned by this process.
    pub(crate) fn owns(&self, node: usize) -> bool {
        self.owned[node]
    }

    /// Number of nodes of the part, owned or not.
    pub(crate) fn len(&self) -> usize {
        self.owned.len()
    }

    /// Replaces `values` by their sums over all processes.
    pub(crate) fn sum(&self, values: &mut [f64]) {
        (self.sum)(values);
    }
}

impl fmt::Debug for MeshPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let owned = self.owned.iter().filter(|owned| **owned).count();
        write!(f, "MeshPart({owned} of {} nodes)", self.owned.len())
    }
}
