//! Shapes of bodies: what they are read from, and how far they reach.

use nalgebra::{UnitQuaternion, Vector3};

/// Shape of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A spheroid: prolate where it is longer than wide, oblate else.
    Spheroid {
        /// Radius of its equator.
        radius: f64,
        /// Half its length along its axis of revolution.
        half_length: f64,
        /// Direction of that axis at the start, a unit vector.
        axis: Vector3<f64>,
    },
    /// A massless point without surface.
    Point,
}

impl Shape {
    /// Radius of the smallest ball about the centre that holds the body; zero for points.
    pub fn bounding_radius(&self) -> f64 {
        match *self {
            Self::Sphere { radius } => radius,
            Self::Spheroid {
                radius,
                half_length,
                ..
            } => radius.max(half_length),
            Self::Point => 0.0,
        }
    }

    /// How far the body reaches from its centre in a direction, a unit vector, when turned by `attitude` since the start.
    pub fn reach(&self, attitude: &UnitQuaternion<f64>, direction: &Vector3<f64>) -> f64 {
        match *self {
            Self::Sphere { radius } => radius,
            Self::Spheroid {
                radius,
                half_length,
                axis,
            } => {
                let along = (attitude * axis).dot(direction);
                let across = (1.0 - along * along).max(0.0).sqrt();
                (half_length * along).hypot(radius * across)
            }
            Self::Point => 0.0,
        }
    }

    /// The farthest that the body reaches across a direction, a unit vector.
    pub fn reach_across(&self, attitude: &UnitQuaternion<f64>, direction: &Vector3<f64>) -> f64 {
        match *self {
            Self::Sphere { radius } => radius,
            Self::Spheroid { radius, axis, .. } => {
                let axis = attitude * axis;
                let across = axis - axis.dot(direction) * direction;
                // the direction nearest to the axis, or that of the equator
                across
                    .try_normalize(0.0)
                    .map_or(radius, |across| self.reach(attitude, &across).max(radius))
            }
            Self::Point => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheroids_reach_their_semi_axes() {
        let shape = Shape::Spheroid {
            radius: 1.0,
            half_length: 3.0,
            axis: Vector3::x(),
        };
        let turned = UnitQuaternion::from_scaled_axis(Vector3::z() * std::f64::consts::FRAC_PI_2);
        for (direction, reach) in [
            (Vector3::x(), 1.0),
            (Vector3::y(), 3.0),
            (Vector3::z(), 1.0),
        ] {
            assert!((shape.reach(&turned, &direction) - reach).abs() < 1e-12);
        }
        assert!((shape.reach_across(&turned, &Vector3::x()) - 3.0).abs() < 1e-12);
        assert!((shape.reach_across(&turned, &Vector3::y()) - 1.0).abs() < 1e-12);
    }
}
