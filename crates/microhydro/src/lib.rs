#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod error;
pub mod multipole;
pub mod oseen;
mod pair_mobility;
mod resistance;
pub mod rpy;
mod spheres;
pub mod wall;

pub use error::HydroError;
pub use multipole::Accuracy;
/// The version of nalgebra whose vectors and matrices this crate takes and returns.
pub use nalgebra;
pub use resistance::Resistance;
pub use spheres::{Medium, Spheres};
