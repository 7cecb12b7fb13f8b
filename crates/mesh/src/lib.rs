//! Quadratic tetrahedral meshes: generation, quality, Gmsh reading, VTU writing.
#![forbid(unsafe_code)]

mod error;
mod linear_tets;
mod surface;
mod tet_mesh;

pub use error::MeshError;
pub use linear_tets::LinearTets;
pub use surface::{Sphere, Surface};
pub use tet_mesh::{Facet, TET_EDGES, TetMesh, Vec3};
