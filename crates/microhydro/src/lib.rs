#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod error;
pub mod multipole;
pub mod oseen;
mod linked;
mod near_pairs;
mod pair_mobility;
mod pair_sums;
mod point_mobility;
mod resistance;
pub mod rpy;
mod spheres;
pub mod wall;

pub use error::HydroError;
pub use multipole::Accuracy;
/// The version of nalgebra whose vectors and matrices this crate takes and returns.
pub use nalgebra;
pub use linked::{LinkedMotion, LinkedSpheres, Linkage};
pub use point_mobility::{PointModel, PointMobility};
pub use resistance::Resistance;
pub use spheres::{Medium, Spheres};
