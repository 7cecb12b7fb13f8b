#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod boundary_polygon;
mod curve;
mod delaunay;
mod element;
mod error;
mod forms;
mod generate;
mod geometry_map;
mod meridian;
mod mesh;
mod point;
mod resistance;
mod rule;
mod space;
mod stokes;
mod swirl;
mod system;

pub use error::AxisymmetricError;
pub use meridian::{Spheroid, Surroundings};
pub use resistance::{AxialResistance, axial_resistance, spin_resistance};

pub use nalgebra;
