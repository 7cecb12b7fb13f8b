//! Sparse direct solvers.

mod factor;
mod graph;
mod saddle_factor;
mod saddle_ldlt;
mod schur;
mod shifted_ldlt;

pub use factor::Precision;
pub(crate) use factor::{Definiteness, SparseFactor};
pub(crate) use graph::Graph;
pub(crate) use saddle_factor::{SaddleFactor, adjacency, weights};
pub use saddle_ldlt::{DirectParams, SaddleLdlt};
pub(crate) use schur::SchurFactor;
pub use shifted_ldlt::ShiftedLdlt;
