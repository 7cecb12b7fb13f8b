#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod added_mass;
mod bodies;
mod continuation;
mod error;
mod integrator;
mod meshes;
mod parameters;
mod projection;
mod remeshing;
mod steady;
mod step;

pub use added_mass::added_mass_forces;
pub use bodies::{BodyMass, Forcing};
pub use continuation::IntegratorState;
pub use error::InertiaError;
pub use integrator::Integrator;
pub use linalg::TimeDerivative;
pub use meshes::{FrozenMesh, MappedMesh, Meshes, SuppliedMesh};
pub use parameters::{Bodies, Convection, Parameters};
pub use projection::ProjectionJump;
pub use steady::{Steady, SteadyFlow, SteadyParameters};
pub use step::{Step, StepReport};

// Types of these crates are part of the interface.
pub use ale;
pub use fem;
pub use linalg;
pub use mesh;
pub use nalgebra;
pub use rigid;
pub use stokes;
