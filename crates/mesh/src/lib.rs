//! Quadratic tetrahedral meshes: generation, quality, Gmsh reading, VTU writing.
//!
//! A [`TetMesh`] is made of loose tets, whether generated, read ([`MshFile`]) or written by hand as here: eight tets
//! make an octahedron; with its edges bent onto the sphere it has 85 % of the sphere's volume instead of 32 %.
//!
//! ```
//! use mesh::{LinearTets, Sphere, TetMesh, Vec3, Vtu};
//! let (x, y, z, o) = (Vec3::x(), Vec3::y(), Vec3::z(), Vec3::zeros());
//! let faces = [[1, 2, 3], [2, 4, 3], [4, 5, 3], [5, 1, 3], [2, 1, 6], [4, 2, 6], [5, 4, 6], [1, 5, 6]];
//! let octahedron = LinearTets {
//!     points: vec![o, x, y, z, -x, -y, -z],
//!     tets: faces.map(|[a, b, c]| [0, a, b, c]).to_vec(),
//!     faces: faces.map(|face| (face, 0)).to_vec(),
//!     tags: vec!["skin".into()],
//! };
//! let sphere = Sphere { centre: o, radius: 1.0 };
//! let straight = TetMesh::straight(octahedron.clone())?;
//! let curved = TetMesh::curved(octahedron, &[("skin", &sphere)])?;
//! assert!((straight.volume() - 4.0 / 3.0).abs() < 1e-15);
//! assert!((curved.volume() - 3.564489).abs() < 1e-6);
//! assert!(curved.quality().min_jacobian > 0.0);
//! let file = Vtu::cells(&curved).to_bytes(); // or `.write("ball.vtu")?`, for ParaView
//! # assert!(file.starts_with(b"<?xml"));
//! # Ok::<(), mesh::MeshError>(())
//! ```
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
mod symmetry;
mod tet_mesh;
mod topology;

pub use error::{MeshError, Place};
pub use generate::{
    Container, GenerateParams, Generated, MeshedBody, SizeMap, StageSeconds, generate,
    generate_sized,
};
pub use io::{MshFile, Pvd, Vtu, VtuEncoding};
pub use linear_tets::LinearTets;
pub use quadratic_tets::QuadraticTets;
pub use quality::{Quality, dihedral_angles, mean_ratio, scaled_jacobian_bound};
pub use surface::{BoxSurface, Capsule, Sphere, Spheroid, Surface};
pub use symmetry::{SYMMETRY_PLANE_TAGS, Unfolded};
pub use tet_mesh::{Facet, NamedSurface, TET_EDGES, TetMesh, Vec3};
