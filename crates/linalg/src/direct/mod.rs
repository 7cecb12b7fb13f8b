//! Sparse direct solvers.

mod factor;
#[cfg(feature = "metis")]
mod graph;
mod ordering;
mod saddle_factor;
mod saddle_ldlt;
mod shifted_ldlt;

pub use factor::Precision;
pub(crate) use factor::{Definiteness, SparseFactor};
#[cfg(feature = "metis")]
pub use graph::partition;
#[cfg(feature = "metis")]
pub(crate) use graph::{Graph, nested_dissection};
#[cfg(not(feature = "metis"))]
pub(crate) use ordering::nested_dissection;
#[cfg(feature = "metis")]
pub(crate) use saddle_factor::{SaddleFactor, adjacency, weights};
pub use saddle_ldlt::{DirectParams, SaddleLdlt};
pub use shifted_ldlt::ShiftedLdlt;
