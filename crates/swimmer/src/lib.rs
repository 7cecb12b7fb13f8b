//! Articulated micro-swimmers in Stokes flow: scenes, gaits, models, integration, output.
#![forbid(unsafe_code)]

mod error;
mod gait;
pub mod model;
pub mod scene;

pub use error::SwimError;
pub use gait::{Leg, legs};
pub use scene::{Gait, Phase, Scene};
