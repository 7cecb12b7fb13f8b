//! Closed surfaces of bodies and containers.

mod bent_tube;
mod box_surface;
mod capsule;
mod disk;
mod ellipsoid;
mod flat_triangles;
mod helix;
mod placed;
mod sphere;
mod spheroid;
mod torus;
pub(crate) mod triangles;
mod triangulated;
mod tube;
mod tube_profile;

pub use bent_tube::{BentTube, Centreline, CurvePoint, TubePoint};
pub use box_surface::BoxSurface;
pub use capsule::Capsule;
pub use disk::Disk;
pub use ellipsoid::Ellipsoid;
pub(crate) use flat_triangles::FlatTriangles;
pub use helix::Helix;
pub use placed::Placed;
pub use sphere::Sphere;
pub(crate) use sphere::sphere_radius;
pub use spheroid::Spheroid;
pub use torus::Torus;
pub(crate) use triangles::euler_characteristic;
pub use triangulated::{CurvedTriangles, TriangleKind, TriangulatedSurface};
pub use tube_profile::TubeProfile;
