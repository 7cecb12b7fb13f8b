#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod boundary_part;
mod box_tree;
mod build;
mod error;
mod file_location;
mod io;
mod jacobian;
mod linear_tets;
mod point_location;
mod quadratic_tets;
mod quality;
mod regions;
mod reverse_cuthill_mckee;
mod submesh;
mod surface;
mod surface_mesh;
mod symmetry;
mod tet;
mod tet_mesh;
mod topology;
mod validity;

pub use box_tree::{BoundingBox, BoxTree};
pub use error::MeshError;
pub use file_location::FileLocation;
pub use io::{MshFile, Pvd, SurfaceFormat, Vtu, VtuEncoding};
pub use jacobian::scaled_jacobian_bound;
pub use linear_tets::LinearTets;
pub use nalgebra;
pub use point_location::{CellPoint, PointLocator};
pub use quadratic_tets::QuadraticTets;
pub use quality::{Quality, dihedral_angles, mean_ratio};
pub use regions::Regions;
pub use submesh::Submesh;
pub use surface::Surface;
pub use surface_mesh::SurfaceMesh;
pub use symmetry::{SYMMETRY_PLANE_TAGS, Unfolded};
pub use tet::{TET_EDGES, Vec3};
pub use tet_mesh::{Facet, NamedSurface, TetMesh};
