//! Sparse direct solvers.

mod factor;
mod order;
mod saddle_ldlt;
mod schur;

pub(crate) use factor::{Definiteness, SparseFactor};
pub(crate) use order::nested_dissection;
pub use saddle_ldlt::{DirectParams, SaddleLdlt};
pub(crate) use schur::SchurFactor;
