#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod error;
mod fast_sums;
mod inverse_root;
mod linked;
mod mean_flow;
pub mod multipole;
mod near_pairs;
pub mod oseen;
mod pair_mobility;
mod pair_sums;
mod periodic;
mod point_mobility;
mod resistance;
pub mod rpy;
mod spheres;
mod squirmer;
pub mod wall;

pub use error::HydroError;
pub use linked::{Linkage, LinkedMotion, LinkedSpheres, Mobility};
pub use multipole::Accuracy;
/// The version of nalgebra whose vectors and matrices this crate takes and returns.
pub use nalgebra;
pub use point_mobility::{PointMobility, PointModel};
pub use resistance::Resistance;
pub use spheres::{Medium, Spheres};
pub use squirmer::Squirmer;
