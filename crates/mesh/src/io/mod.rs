//! Mesh files: Gmsh MSH in, VTU (ParaView) and MSH out.

mod msh;

pub use msh::MshFile;
