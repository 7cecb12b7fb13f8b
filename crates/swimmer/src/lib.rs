//! Articulated micro-swimmers in Stokes flow: scenes, gaits, models, integration, output.
#![forbid(unsafe_code)]

mod error;
mod gait;
mod integrate;
pub mod model;
pub mod scene;

pub use error::SwimError;
pub use gait::{Leg, legs};
pub use integrate::{Integrator, LegResult, Method, PathPiece, Solved};
pub use scene::{Gait, Phase, Scene};
