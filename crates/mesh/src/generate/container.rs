//! What holds the fluid.

use crate::{BoxSurface, Capsule, Sphere, Surface};

/// Edges on a ball or a cylinder are at most this part of its radius: quadratic edges then stay within `0.4^4 / 384` radii, below 1e-4, of it.
const OF_RADIUS: f64 = 0.4;

/// Edges in a box are at most this part of its shortest side, for three layers of cells between opposite walls.
const OF_SIDE: f64 = 1.0 / 3.0;

/// The container of the fluid; its facets are tagged [`Container::TAG`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Container {
    /// The inside of a sphere.
    Ball(Sphere),
    /// The inside of a box with sides along the axes.
    Box(BoxSurface),
    /// The inside of a cylinder closed by hemispheres.
    ///
    /// Edges on its wall have one length, the smallest that is wanted anywhere on it: bodies close to the wall make it fine all along.
    Capsule(Capsule),
}

impl Container {
    /// Tag of the container's facets.
    pub const TAG: &'static str = "outer";

    /// The wall; negative distances are inside the container, where the fluid is.
    pub fn surface(&self) -> &dyn Surface {
        match self {
            Self::Ball(sphere) => sphere,
            Self::Box(surface) => surface,
            Self::Capsule(capsule) => capsule,
        }
    }

    /// The longest edges that make sense in it.
    pub(super) fn largest_size(&self) -> f64 {
        match self {
            Self::Ball(sphere) => OF_RADIUS * sphere.radius,
            Self::Capsule(capsule) => OF_RADIUS * capsule.radius,
            Self::Box(surface) => OF_SIDE * (surface.max - surface.min).min(),
        }
    }
}
