//! Gmsh MSH files: reader and writer.
//!
//! The reader accepts versions 4.1 and 2, text and binary, first and second order. The writer
//! produces 4.1 text.
//!
//! The reader is our own because the only crate for it (mshio 0.4) reads 4.1 only, skips the names
//! of groups, and gives neither line nor offset of an error.

mod gather;
mod msh_file;
mod read;
mod scan;
mod version2;
mod version4;
mod write;

pub use msh_file::MshFile;
pub(super) use read::surface_of_msh;
pub(super) use write::write_msh;
