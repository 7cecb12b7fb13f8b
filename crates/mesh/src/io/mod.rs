//! Mesh files: Gmsh MSH, STL and OBJ in, VTU (ParaView) and MSH out.

mod atomic_file;
mod msh;
mod surface_file;
mod vtu;
mod write;

pub use atomic_file::write_atomically;
pub use msh::MshFile;
pub use surface_file::SurfaceFormat;
pub use vtu::{Pvd, Vtu, VtuEncoding};
