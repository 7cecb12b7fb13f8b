//! Quadratic tetrahedral meshes: generation, quality, Gmsh reading, VTU writing.
#![forbid(unsafe_code)]

mod build;
mod delaunay;
mod error;
mod generate;
mod io;
mod linear_tets;
mod order;
mod quadratic_tets;
mod quality;
mod surface;
mod tet_mesh;
mod topology;

pub use error::{MeshError, Place};
pub use generate::{Body, Container, Generated, GenerateParams, Stages, generate};
pub use io::{MshFile, Pvd, Vtu, VtuEncoding};
pub use linear_tets::LinearTets;
pub use quadratic_tets::QuadraticTets;
pub use quality::{Quality, dihedral_angles, mean_ratio, scaled_jacobian_bound};
pub use surface::{BoxSurface, Sphere, Spheroid, Surface};
pub use tet_mesh::{Facet, NamedSurface, TET_EDGES, TetMesh, Vec3};
