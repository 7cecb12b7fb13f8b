#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod box_tree;
mod build;
mod error;
mod grouped;
mod io;
mod jacobian;
mod linear_tets;
mod point_location;
mod quadratic_tets;
mod quality;
mod reverse_cuthill_mckee;
mod surface;
mod surface_checks;
mod tet_mesh;
mod topology;

pub use box_tree::{BoundingBox, BoxTree};
pub use build::{Submesh, Unfolded};
pub use error::{FileLocation, MeshError};
pub use grouped::Grouped;
pub use io::{
    InputFile, MAX_MESH_FILE, MshFile, Pvd, SurfaceFormat, Vtu, VtuEncoding, content_hash,
    is_temporary_file, write_atomically,
};
pub use jacobian::scaled_jacobian_bound;
pub use linear_tets::{LinearTets, Regions, TET_EDGES, Vec3, used_points};
pub use nalgebra;
pub use point_location::{CellPoint, PointLocator};
pub use quadratic_tets::QuadraticTets;
pub use quality::{Quality, dihedral_angles, has_volume, mean_ratio};
pub use surface::{Surface, SurfaceMesh};
pub use surface_checks::check_surface;
pub use tet_mesh::{Facet, NamedSurface, SYMMETRY_PLANE_TAGS, TetMesh};
