//! Mesh motion: harmonic extension of the motions of rigid bodies into a mesh, with a guard on its validity.
#![forbid(unsafe_code)]

mod dirichlet;
mod error;
mod reference_map;
mod stiffening;

pub use error::AleError;
pub use reference_map::{MovingBody, ReferenceMap};
pub use stiffening::Stiffening;
