//! Estimates of the discretisation error from the cubic part of the residual.

mod bubbles;
mod cell;
mod functional;
mod surplus;

pub use functional::ErrorFunctional;
pub use surplus::{Surplus, SurplusSpace};
