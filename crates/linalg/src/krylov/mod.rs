//! Krylov methods that stop on, and report, the true residual.

mod basis;
mod cg;
mod fgmres;
mod minres;
mod progress;
mod report;

pub use cg::cg;
pub use fgmres::fgmres;
pub use minres::minres;
pub use report::{KrylovParams, SolveReport};
