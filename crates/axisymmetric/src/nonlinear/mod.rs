//! Flows that no resistance matrix describes: with inertia or with a viscosity law.

mod added_mass;
mod axial_forces;
mod bodies;
mod continuation;
mod drive;
mod energy;
mod flow_system;
mod flow_transfer;
mod forcing;
mod front;
mod impedance;
mod integrator;
mod law_change;
mod locator;
mod mesh_motion;
mod momentum;
mod nested_condensation;
mod orders;
mod problem;
mod response;
mod steady;
mod transient_parameters;
mod viscosity;

pub use added_mass::{AddedMass, added_mass};
pub use axial_forces::{AxialForceSolver, AxialForces};
pub use bodies::{AxialBody, AxialMotion};
pub use continuation::AxialState;
pub use drive::{Slip, SteadyDrive, SteadyParameters};
pub use forcing::AxialForcing;
pub use impedance::{Impedance, ImpedanceParameters, impedance};
pub use integrator::{AxialIntegrator, AxialStep};
pub use law_change::{AxialChange, LawChange, law_change};
pub use problem::SteadyState;
pub(crate) use problem::{TriangleValues, law_flow};
pub use steady::{REGULARISATION_FACTOR, steady_state};
pub use transient_parameters::{Convection, TransientParameters};
