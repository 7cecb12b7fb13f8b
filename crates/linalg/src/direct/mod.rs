//! Sparse direct solvers.

mod factor;
mod order;

pub(crate) use factor::{Definiteness, SparseFactor};
pub(crate) use order::nested_dissection;
