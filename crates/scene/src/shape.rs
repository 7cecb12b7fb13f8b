//! Shapes of bodies and their support functions.

use nalgebra::{UnitQuaternion, Vector3};

use crate::words::ShapeKind;

/// Shape of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A sphere.
    Sphere {
        /// Radius.
        radius: f64,
    },
    /// A spheroid: prolate if `half_length > radius`, oblate if `half_length < radius`.
    Spheroid {
        /// Radius of the equator.
        radius: f64,
        /// Half of the length along the axis of revolution.
        half_length: f64,
        /// Direction of the axis of revolution in the initial configuration, a unit vector.
        axis: Vector3<f64>,
    },
    /// A massless point without a surface.
    Point,
}

impl Shape {
    /// Kind of the shape, as in the scene file.
    pub fn kind(&self) -> ShapeKind {
        match self {
            Self::Sphere { .. } => ShapeKind::Sphere,
            Self::Spheroid { .. } => ShapeKind::Spheroid,
            Self::Point => ShapeKind::Point,
        }
    }

    /// Radius of the smallest ball about the centre that contains the body; zero for points.
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

    /// Support distance `max n · (x - c)` over the points `x` of the body with centre `c`.
    ///
    /// `direction` is the unit vector `n`; `rotation` is relative to the initial configuration.
    pub fn support_distance(
        &self,
        rotation: &UnitQuaternion<f64>,
        direction: &Vector3<f64>,
    ) -> f64 {
        match *self {
            Self::Sphere { radius } => radius,
            Self::Spheroid {
                radius,
                half_length,
                axis,
            } => {
                let along = (rotation * axis).dot(direction);
                let across = (1.0 - along * along).max(0.0).sqrt();
                (half_length * along).hypot(radius * across)
            }
            Self::Point => 0.0,
        }
    }

    /// Largest support distance over all directions perpendicular to `direction`, a unit vector.
    ///
    /// `rotation` is relative to the initial configuration.
    pub fn transverse_support_distance(
        &self,
        rotation: &UnitQuaternion<f64>,
        direction: &Vector3<f64>,
    ) -> f64 {
        match *self {
            Self::Sphere { radius } => radius,
            Self::Spheroid { radius, axis, .. } => {
                let axis = rotation * axis;
                let across = axis - axis.dot(direction) * direction;
                // The maximum is attained at the direction nearest to the axis (prolate) or on the
                // equator (oblate).
                across.try_normalize(0.0).map_or(radius, |across| {
                    self.support_distance(rotation, &across).max(radius)
                })
            }
            Self::Point => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn support_distances_of_a_spheroid_along_its_axes_are_its_semi_axes() {
        let shape = Shape::Spheroid {
            radius: 1.0,
            half_length: 3.0,
            axis: Vector3::x(),
        };
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::z() * std::f64::consts::FRAC_PI_2);
        for (direction, expected) in [
            (Vector3::x(), 1.0),
            (Vector3::y(), 3.0),
            (Vector3::z(), 1.0),
        ] {
            assert!((shape.support_distance(&rotation, &direction) - expected).abs() < 1e-12);
        }
        assert!((shape.transverse_support_distance(&rotation, &Vector3::x()) - 3.0).abs() < 1e-12);
        assert!((shape.transverse_support_distance(&rotation, &Vector3::y()) - 1.0).abs() < 1e-12);
    }
}
