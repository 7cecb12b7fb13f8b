//! Bodies of revolution that move along their common axis: elements of high order in the meridian half-plane.
//!
//! Flow without swirl around bodies on an axis needs two dimensions. There, smooth bodies allow elements whose order does the
//! work: triangles grow with the distance from the bodies, bend along them, and the error falls by a factor of about ten with each order.
//! [`axial_resistance`] climbs orders until the error meets a tolerance and says what is left; [`spin_resistance`] does so for turning about the axis.
#![forbid(unsafe_code)]

mod curve;
mod delaunay;
mod element;
mod error;
mod forms;
mod meridian;
mod mesh;
mod resistance;
mod rule;
mod shape;
mod space;
mod stokes;
mod swirl;
mod system;

pub use error::AxisymmetricError;
pub use meridian::{Spheroid, Surroundings};
pub use resistance::{AxialResistance, axial_resistance, spin_resistance};
