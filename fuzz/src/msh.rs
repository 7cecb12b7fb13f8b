//! Gmsh files.

use mesh::MshFile;

/// Reads a file, and makes the mesh that it describes.
pub fn read(bytes: &[u8]) {
    if let Ok(file) = MshFile::parse("fuzzed.msh", bytes) {
        drop(file.into_mesh(&[]));
    }
}
