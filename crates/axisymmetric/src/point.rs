//! Points of the meridian half-plane.

use nalgebra::Vector2;

/// A point `(z, r)` of the meridian half-plane: position along the axis and distance from it.
pub(crate) type Point = Vector2<f64>;
