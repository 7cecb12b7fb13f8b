#![doc = include_str!("../README.md")]
#![deny(unsafe_code)]

mod assembly;
mod divided;
mod error;
mod ffi;
mod gather;
mod handles;
mod hierarchy;
mod numbering;
mod partition;
mod pressure;
mod shared;
mod solve;
mod solver;

pub use error::PetscError;
pub use handles::Session;
pub use solve::{DistributedSolution, PetscEngine, solve};

// Types of these crates are part of the interface.
pub use rigid;
pub use stokes;
