//! Stokes flow around rigid bodies on one tetrahedral mesh: one instantaneous solution.
//!
//! A [`Problem`] names the bodies and walls of a mesh. [`Problem::solve`] gives velocities, forces
//! and pressure for bodies that links and loads drive; [`Problem::resistance`] condenses the flow on
//! the bodies; [`Problem::solve_all`] serves several rates of the links with one matrix, starts from
//! earlier solutions and estimates the discretisation error of every velocity and force.
//!
//! Everything is in scaled units: viscosity 1, lengths of the order of a body. The crate does not
//! generate or move meshes (`mesh`, `ale`) and does not integrate in time.
#![forbid(unsafe_code)]

mod checks;
mod error;
mod estimate;
mod linear;
mod options;
mod problem;
mod report;
mod resistance;
mod solve;

pub use checks::Checks;
pub use error::StokesError;
pub use estimate::Estimate;
pub use options::{Options, Solver};
pub use problem::Problem;
pub use report::{Dofs, Seconds, SolverReport};
pub use solve::{InitialGuesses, Solution};
