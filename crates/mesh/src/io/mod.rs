//! Mesh files: Gmsh MSH in, VTU (ParaView) and MSH out.

mod atomic;
mod msh;
mod vtu;

use std::path::Path;

pub use msh::MshFile;
pub use vtu::{Pvd, Vtu, VtuEncoding};

use crate::{MeshError, TetMesh};

impl TetMesh {
    /// Writes the mesh as the ending of the name says: `.msh` (Gmsh 4.1, text, second order) or `.vtu` (cells and their
    /// scaled Jacobian).
    ///
    /// The file is whole or not there. What `.msh` holds reads back as the same mesh up to the order of vertices.
    ///
    /// # Errors
    /// [`MeshError::UnknownFormat`], [`MeshError::Io`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), MeshError> {
        let path = path.as_ref();
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("msh") => msh::write_msh(self, path),
            Some("vtu") => {
                let jacobians: Vec<f64> = (0..self.n_cells())
                    .map(|cell| self.scaled_jacobian(cell))
                    .collect();
                Vtu::cells(self)
                    .cell_field("scaled_jacobian", 1, &jacobians)?
                    .write(path)
            }
            _ => Err(MeshError::UnknownFormat { path: path.into() }),
        }
    }
}
