//! Fluids with inertia: steady states, oscillations and steps in time of bodies on one axis.

mod bodies;
mod flow_system;
mod flow_transfer;
mod forcing;
mod impedance;
mod integrator;
mod mesh_motion;
mod momentum;
mod nested_condensation;
mod orders;
mod steady;

pub use bodies::{AxialBody, AxialMotion};
pub use forcing::AxialForcing;
pub use impedance::{Impedance, ImpedanceParameters, impedance};
pub use integrator::{AxialIntegrator, AxialStep, Convection, TransientParameters};
pub use steady::{Slip, SteadyDrive, SteadyParameters, SteadyState, steady_state};
