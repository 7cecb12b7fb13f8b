//! Mesh files: Gmsh MSH in, VTU (ParaView) and MSH out.

mod atomic;
mod msh;
mod vtu;
mod write;

pub use msh::MshFile;
pub use vtu::{Pvd, Vtu, VtuEncoding};
