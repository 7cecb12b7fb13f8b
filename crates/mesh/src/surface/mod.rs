//! Closed surfaces of bodies and containers.

mod boundary_part;
mod box_surface;
mod capsule;
mod closed_surface;
mod disk;
mod ellipsoid;
mod flat_triangles;
mod helix;
mod placed;
mod sphere;
mod spheroid;
mod surface_mesh;
mod torus;
mod triangulated;
mod tube;

pub use box_surface::BoxSurface;
pub use capsule::Capsule;
pub use closed_surface::Surface;
pub(crate) use closed_surface::sphere_radius;
pub use disk::Disk;
pub use ellipsoid::Ellipsoid;
pub(crate) use flat_triangles::FlatTriangles;
pub use helix::Helix;
pub use placed::Placed;
pub use sphere::Sphere;
pub use spheroid::Spheroid;
pub use surface_mesh::SurfaceMesh;
pub(crate) use surface_mesh::euler_characteristic;
pub use torus::Torus;
pub use triangulated::{TriangleKind, TriangulatedSurface};
