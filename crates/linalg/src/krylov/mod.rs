//! Krylov methods that stop on the true residual and report it.

mod basis;
mod cg;
mod complement;
mod fgmres;
mod hessenberg;
mod minres;
mod null_vectors;
mod progress;
mod report;

pub use basis::OrthonormalBasis;
pub use cg::cg;
pub use fgmres::{fgmres, fgmres_columns};
pub use minres::minres;
pub use null_vectors::NullVectors;
pub use report::{ERROR_OVER_RESIDUAL, KrylovParams, SolveReport};
