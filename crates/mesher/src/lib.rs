#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

/// Methods that set a public field each and return the struct.
macro_rules! setters {
    ($type:ident { $($set:ident($field:ident: $value:ty),)* }) => {
        impl $type {
            $(
                #[doc = concat!("Sets [`", stringify!($field), "`](Self::", stringify!($field), ").")]
                #[must_use]
                pub fn $set(mut self, $field: $value) -> Self {
                    self.$field = $field;
                    self
                }
            )*
        }
    };
}

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
    BentTube, BoxSurface, Capsule, Centreline, CurvePoint, CurvedTriangles, Disk, Ellipsoid, Helix,
    Placed, Sphere, Spheroid, Torus, TriangleKind, TriangulatedSurface, TubePoint, TubeProfile,
};
