#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod delaunay;
mod error;
mod generate;
mod remesh;
mod surface;

pub use error::GenerateError;
pub use generate::{
    Container, GenerateParams, Generated, MeshedBody, SizeMap, StageSeconds, clearance, generate,
    generate_sized,
};
pub use mesh;
pub use remesh::{MovedBody, remesh, remesh_by_gmsh};
pub use surface::{
    BoxSurface, Capsule, Disk, Ellipsoid, Helix, Placed, Sphere, Spheroid, Torus, TriangleKind,
    TriangulatedSurface,
};
