//! Estimates of the discretisation error: the cubic part of the residual, and what straight facets cut off.

mod bubbles;
mod cell;
mod chords;
mod functional;
mod surplus;

pub use chords::{Chords, RoundPart};
pub use functional::ErrorFunctional;
pub use surplus::{Surplus, SurplusSpace};
