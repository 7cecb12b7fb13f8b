#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod bodies;
mod error;
mod integrator;
mod meshes;
mod parameters;
mod projection;
mod steady;

pub use bodies::{BodyMass, Forcing};
pub use error::InertiaError;
pub use integrator::{Integrator, Step, StepReport};
pub use linalg::TimeDerivative;
pub use meshes::{FrozenMesh, MappedMesh, Meshes};
pub use parameters::{Bodies, Convection, Parameters};
pub use projection::ProjectionJump;
pub use steady::{Steady, SteadyFlow, SteadyParameters};

// Types of these crates are part of the interface.
pub use ale;
pub use fem;
pub use linalg;
pub use mesh;
pub use nalgebra;
pub use rigid;
pub use stokes;
