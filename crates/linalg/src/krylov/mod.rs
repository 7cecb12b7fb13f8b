//! Krylov methods that stop on, and report, the true residual.

mod basis;
mod cg;
mod fgmres;
mod report;

pub use cg::cg;
pub use fgmres::fgmres;
pub use report::{KrylovParams, SolveReport};
