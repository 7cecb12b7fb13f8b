//! A fluid that is divided between processes.

use std::borrow::Cow;
use std::fmt;
use std::sync::Arc;

/// Replaces numbers of this process by their sums over all processes.
///
/// It is called by every process in the same order with equally many numbers, on the thread that
/// calls this crate. A sum that fails writes NaN, which later checks refuse.
pub type SumOverParts = Arc<dyn Fn(&mut [f64]) + Send + Sync>;

/// Replaces the entries of a vector that other processes own by theirs.
///
/// Called as [`SumOverParts`]. A call that fails writes NaN.
pub type UpdateGhosts = Arc<dyn Fn(&mut [f64]) + Send + Sync>;

/// The nodes of a mesh whose equations belong to this process.
///
/// Each process passes the matrices of its part: all cells around the nodes that it owns, so that
/// the rows of these nodes are complete. The other nodes of these cells are owned by other
/// processes; their rows are incomplete and are not used. Every node of the whole mesh has one
/// owner. All that belongs to bodies and joints is the same on every process.
///
/// A vector of a divided system has entries for all nodes of the part. Those of nodes of other
/// processes are zero, and so are those of the border except on one process, so that products of
/// vectors are sums over the processes.
#[derive(Clone)]
pub struct MeshPart {
    owned: Vec<bool>,
    sum: SumOverParts,
    /// Whether this process owns the border, and the exchange of vectors.
    ghosts: Option<(bool, UpdateGhosts)>,
}

impl MeshPart {
    /// A part that owns the nodes with `owned`, one flag per node of the part.
    pub fn new(owned: Vec<bool>, sum: SumOverParts) -> Self {
        Self {
            owned,
            sum,
            ghosts: None,
        }
    }

    /// The same part with the exchange of vectors of the system `[velocity | border | pressure]`.
    ///
    /// `owns_border` holds on one process. Without an exchange, vectors that are passed to
    /// [`Constrained`](crate::Constrained) must have the entries of all nodes of the part.
    #[must_use]
    pub fn with_ghosts(self, owns_border: bool, update: UpdateGhosts) -> Self {
        Self {
            ghosts: Some((owns_border, update)),
            ..self
        }
    }

    /// Number of nodes of the part, owned or not.
    pub(crate) fn len(&self) -> usize {
        self.owned.len()
    }
}

/// What belongs to this process; everything, if the mesh is not divided.
pub(crate) trait Ownership {
    /// Whether the equations of a node belong to this process.
    fn owns(&self, node: usize) -> bool;

    /// Whether the border entries of a vector belong to this process.
    fn owns_border(&self) -> bool;

    /// The vector with the entries of other processes.
    fn completed<'v>(&self, vector: &'v [f64]) -> Cow<'v, [f64]>;

    /// Replaces `values` by their sums over all processes.
    fn sum(&self, values: &mut [f64]);
}

impl Ownership for Option<MeshPart> {
    fn owns(&self, node: usize) -> bool {
        self.as_ref().is_none_or(|part| part.owned[node])
    }

    fn owns_border(&self) -> bool {
        let ghosts = self.as_ref().and_then(|part| part.ghosts.as_ref());
        ghosts.is_none_or(|(owns, _)| *owns)
    }

    fn completed<'v>(&self, vector: &'v [f64]) -> Cow<'v, [f64]> {
        match self.as_ref().and_then(|part| part.ghosts.as_ref()) {
            None => Cow::Borrowed(vector),
            Some((_, update)) => {
                let mut all = vector.to_vec();
                update(&mut all);
                Cow::Owned(all)
            }
        }
    }

    fn sum(&self, values: &mut [f64]) {
        if let Some(part) = self {
            (part.sum)(values);
        }
    }
}

impl fmt::Debug for MeshPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let owned = self.owned.iter().filter(|owned| **owned).count();
        write!(f, "MeshPart({owned} of {} nodes)", self.owned.len())
    }
}
