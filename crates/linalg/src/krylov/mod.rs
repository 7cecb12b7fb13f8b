//! Krylov methods that stop on, and report, the true residual.

mod basis;
mod cg;
mod fgmres;
mod hessenberg;
mod minres;
mod progress;
mod report;

#[cfg(feature = "roofline")]
pub(crate) use basis::visit_basis_kernels;
pub use cg::cg;
pub use fgmres::{fgmres, fgmres_columns};
pub use minres::minres;
pub use report::{KrylovParams, SolveReport};
