//! Estimates of the discretisation error from the cubic part of the residual.

mod bubbles;
mod cell;
mod surplus;

pub use surplus::{Surplus, SurplusSpace};
