//! Fluids with inertia: steady states, oscillations and steps in time of bodies on one axis.

mod bodies;
mod flow_system;
mod momentum;
mod nested_condensation;
mod steady;

pub use bodies::{AxialBody, AxialMotion};
pub use steady::{Slip, SteadyDrive, SteadyParameters, SteadyState, steady_state};
