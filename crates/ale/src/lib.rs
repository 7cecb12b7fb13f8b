#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod biharmonic;
mod bodies;
mod elastic;
mod error;
mod extension;
mod harmonic;
mod motion;
mod rbf;
mod reference_map;

pub use biharmonic::Biharmonic;
pub use bodies::MovingBody;
pub use elastic::Elastic;
pub use error::AleError;
pub use harmonic::{Harmonic, Stiffening};
pub use motion::{MeshMotion, MovingMesh};
pub use rbf::{Kernel, Rbf};
pub use reference_map::{ReferenceMap, SurfaceDisplacement};

// meshes and isometries are part of this crate's interface
pub use mesh;
pub use nalgebra;
