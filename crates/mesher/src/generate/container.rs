//! Containers of the fluid.

use crate::{BoxSurface, Capsule, Sphere, TriangulatedSurface};
use mesh::{Surface, Vec3};

/// Largest edge on a ball or cylinder, as a fraction of its radius, and on other smooth shapes as a
/// fraction of the radius of curvature and of that of the largest ball inside.
///
/// Quadratic edges then stay within `0.4^4 / 384` radii, below 1e-4, of the surface.
const OF_RADIUS: f64 = 0.4;

/// Largest edge in a box, as a fraction of its shortest side: three layers of cells between
/// opposite walls.
const OF_SIDE: f64 = 1.0 / 3.0;

/// The container of the fluid; its facets are tagged [`Container::TAG`].
#[derive(Clone, Debug, PartialEq)]
pub enum Container {
    /// The inside of a sphere.
    Ball(Sphere),
    /// The inside of a box with sides along the axes.
    Box(BoxSurface),
    /// The inside of a cylinder closed by hemispheres.
    ///
    /// All edges on its wall have the same length, the smallest needed anywhere on it: one body
    /// close to the wall makes the whole wall fine.
    Capsule(Capsule),
    /// The inside of a closed surface of triangles.
    Surface(TriangulatedSurface),
}

impl Container {
    /// Tag of the container's facets.
    pub const TAG: &'static str = "outer";

    /// Surface of the container; distances are negative inside, where the fluid is.
    pub fn surface(&self) -> &dyn Surface {
        match self {
            Self::Ball(sphere) => sphere,
            Self::Box(surface) => surface,
            Self::Capsule(capsule) => capsule,
            Self::Surface(surface) => surface,
        }
    }

    /// Longest edge with which the container is resolved.
    pub(super) fn largest_size(&self) -> f64 {
        match self {
            Self::Ball(sphere) => OF_RADIUS * sphere.radius,
            Self::Capsule(capsule) => OF_RADIUS * capsule.radius,
            Self::Box(surface) => OF_SIDE * (surface.max - surface.min).min(),
            Self::Surface(surface) => OF_RADIUS * surface.inradius(),
        }
    }

    /// Longest edge at a point that the curvature and the narrow parts of the container allow, if
    /// they vary.
    pub(super) fn local_size(&self, point: Vec3, growth: f64) -> f64 {
        match self {
            Self::Surface(surface) => surface.curvature_size(point, OF_RADIUS, growth),
            Self::Ball(_) | Self::Capsule(_) | Self::Box(_) => f64::INFINITY,
        }
    }
}
