//! Mesh files: Gmsh MSH, STL and OBJ in, VTU (ParaView) and MSH out.

mod atomic_file;
mod input_file;
mod msh;
mod surface_file;
mod vtu;

pub use atomic_file::{is_temporary_file, write_atomically};
pub use input_file::{InputFile, MAX_MESH_FILE, content_hash};
pub use msh::MshFile;
pub use surface_file::SurfaceFormat;
pub use vtu::{Pvd, Vtu, VtuEncoding};

use std::path::Path;

use crate::{MeshError, TetMesh};
use msh::write_msh;

impl TetMesh {
    /// Writes the mesh in the format given by the file extension.
    ///
    /// `.msh` is Gmsh 4.1, text, second order; it reads back as the same mesh up to the order of
    /// the vertices. `.vtu` has the cells with their scaled Jacobian and, if there are any, the
    /// numbers of their regions. The file is complete or absent, never half written.
    ///
    /// # Errors
    /// [`MeshError::UnknownFormat`], [`MeshError::Io`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), MeshError> {
        let path = path.as_ref();
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("msh") => write_msh(self, path),
            Some("vtu") => {
                let jacobians: Vec<f64> = (0..self.n_cells())
                    .map(|cell| self.scaled_jacobian(cell))
                    .collect();
                let mut file = Vtu::cells(self).cell_field("scaled_jacobian", 1, &jacobians)?;
                let regions = &self.regions().of_cells;
                if !regions.is_empty() {
                    let numbers: Vec<f64> = regions.iter().map(|&r| f64::from(r)).collect();
                    file = file.cell_field("region", 1, &numbers)?;
                }
                file.write(path)
            }
            _ => Err(MeshError::UnknownFormat { path: path.into() }),
        }
    }
}
