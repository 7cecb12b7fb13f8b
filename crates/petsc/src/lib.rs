#![doc = include_str!("../README.md")]
#![deny(unsafe_code)]

mod assembly;
mod engine;
mod error;
mod ffi;
mod handles;
mod hierarchy;
mod numbering;
mod partition;
mod pressure_laplacian;
mod solve;
mod solver;

pub use engine::PetscEngine;
pub use error::PetscError;
pub use handles::Session;
pub use solve::{DistributedSolution, solve};
pub use solver::Method;

// Types of these crates are part of the interface.
pub use rigid;
pub use stokes;
