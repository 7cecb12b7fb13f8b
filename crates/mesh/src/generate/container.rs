//! Containers of the fluid.

use crate::{BoxSurface, Capsule, Sphere, Surface};

/// Largest edge on a ball or cylinder, as a fraction of its radius.
///
/// Quadratic edges then stay within `0.4^4 / 384` radii, below 1e-4, of the surface.
const OF_RADIUS: f64 = 0.4;

/// Largest edge in a box, as a fraction of its shortest side: three layers of cells between
/// opposite walls.
const OF_SIDE: f64 = 1.0 / 3.0;

/// The container of the fluid; its facets are tagged [`Container::TAG`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
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
        }
    }

    /// Longest edge with which the container is resolved.
    pub(super) fn largest_size(&self) -> f64 {
        match self {
            Self::Ball(sphere) => OF_RADIUS * sphere.radius,
            Self::Capsule(capsule) => OF_RADIUS * capsule.radius,
            Self::Box(surface) => OF_SIDE * (surface.max - surface.min).min(),
        }
    }
}
