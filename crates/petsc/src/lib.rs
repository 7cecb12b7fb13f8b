#![doc = include_str!("../README.md")]
#![deny(unsafe_code)]

mod assembly;
mod divided;
mod engine;
mod error;
mod ffi;
mod gather;
mod handles;
mod hierarchy;
mod method;
mod numbering;
mod partition;
mod pressure_block;
mod pressure_laplacian;
mod shared;
mod solve;
mod solver;

pub use engine::PetscEngine;
pub use error::PetscError;
pub use handles::Session;
pub use method::Method;
pub use solve::{DistributedSolution, Parameters, solve};

// Types of these crates are part of the interface.
pub use rigid;
pub use stokes;
