#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod adjoint;
mod checks;
mod cubic;
mod engine;
mod equations;
mod error;
mod estimate;
mod flow;
mod linear;
mod matrices;
mod options;
mod part;
mod permeability;
mod problem;
mod report;
mod resistance;
mod slip_power;
mod solve;
mod surface_flow;

pub use checks::Checks;
pub use engine::Engine;
pub use equations::{Gather, PartEquations};
pub use error::StokesError;
pub use estimate::Estimate;
pub use flow::{Flow, VectorField, solve_stokes};
pub use matrices::fluid_matrices;
pub use options::{Options, Solver};
pub use problem::Problem;
pub use report::{Dofs, Seconds, SolverReport};
pub use solve::{InitialGuesses, Solution};
pub use surface_flow::SurfaceFlow;

// Types of these crates are part of the interface.
pub use fem;
pub use linalg;
pub use mesh;
pub use nalgebra;
pub use rigid;
