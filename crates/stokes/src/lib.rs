#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod adjoint;
mod checks;
mod cubic;
mod equations;
mod error;
mod estimate;
mod flow;
mod generalised_newtonian;
mod inertial;
mod inertial_change;
mod inertial_terms;
mod linear;
mod linearised;
mod newton;
mod newton_start;
mod options;
mod permeability;
mod problem;
mod resistance;
mod solution;
mod solve;
mod surface_flow;
mod surface_power;
mod viscosity_change;
mod viscous_stress;

pub use checks::Checks;
pub use equations::{Gather, PartEquations};
pub use error::StokesError;
pub use estimate::Estimate;
pub use flow::{Flow, VectorField, solve_stokes};
pub use generalised_newtonian::GeneralisedNewtonianSolution;
pub use inertial::InertialSystem;
pub use inertial_change::{ChangingFlow, InertialChange};
pub use inertial_terms::InertialTerms;
pub use linear::Solver;
pub use newton::{NewtonReport, NewtonStep};
pub use options::{Engine, Options};
pub use problem::{Problem, fluid_matrices};
pub use solution::{Dofs, Regularisation, Seconds, Solution, SolvedBatch, SolverReport};
pub use solve::InitialGuesses;
pub use surface_flow::SurfaceFlow;
pub use surface_power::SurfacePowers;
pub use viscosity_change::ViscosityChange;

// Types of these crates are part of the interface.
pub use fem;
pub use linalg;
pub use mesh;
pub use nalgebra;
pub use rheology;
pub use rigid;
