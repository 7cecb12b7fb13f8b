//! Smooth closed surfaces of bodies and containers.

mod box_surface;
mod capsule;
mod closed_surface;
mod sphere;
mod spheroid;

pub use box_surface::BoxSurface;
pub use capsule::Capsule;
pub use closed_surface::Surface;
pub(crate) use closed_surface::sphere_radius;
pub use sphere::Sphere;
pub use spheroid::Spheroid;
