//! Shapes of bodies: what they are read from, and how far they reach.

use nalgebra::{UnitQuaternion, Vector3};

use super::ShapeKind;
use super::build::Checks;
use super::file::BodyFile;
use crate::SwimError;

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

/// The shape of a body of a scene file.
///
/// # Errors
/// A key that the shape needs and has not, or has and does not need.
pub(super) fn read(checks: &Checks, number: usize, file: &BodyFile) -> Result<Shape, SwimError> {
    let key = |key: &str| format!("bodies[{number}].{key}");
    let kind = file.shape.as_deref().and_then(ShapeKind::of);
    let shape = match kind.unwrap_or(ShapeKind::Sphere) {
        ShapeKind::Sphere => {
            let radius =
                checks.required(&key("radius"), file.radius, ": a sphere needs a radius")?;
            Shape::Sphere { radius }
        }
        ShapeKind::Point if file.radius.is_some() => {
            return Err(checks.bad(&key("radius"), "makes no sense for a point; remove it"));
        }
        ShapeKind::Point if file.torque.is_some() => {
            return Err(checks.bad(
                &key("torque"),
                "cannot act on a point, which has no attitude; remove it",
            ));
        }
        ShapeKind::Point => Shape::Point,
        ShapeKind::Spheroid => {
            let radius = checks.required(
                &key("radius"),
                file.radius,
                ": a spheroid needs the radius of its equator",
            )?;
            let half_length = checks.required(
                &key("half_length"),
                file.half_length,
                ": a spheroid needs half its length along its axis",
            )?;
            let axis = Vector3::from(file.axis.unwrap_or([1.0, 0.0, 0.0]));
            let unit = axis
                .try_normalize(0.0)
                .ok_or_else(|| checks.bad(&key("axis"), "must not be zero: it is a direction"))?;
            // what was written by us is read as it was
            let is_unit = (axis.norm() - 1.0).abs() <= 2.0 * f64::EPSILON;
            let axis = if is_unit { axis } else { unit };
            Shape::Spheroid {
                radius,
                half_length,
                axis,
            }
        }
    };
    if !matches!(shape, Shape::Spheroid { .. }) {
        let given = [
            ("half_length", file.half_length.is_some()),
            ("axis", file.axis.is_some()),
        ];
        if let Some((name, _)) = given.iter().find(|(_, given)| *given) {
            return Err(checks.bad(
                &key(name),
                "belongs to shape = \"spheroid\"; remove it or say so",
            ));
        }
    }
    Ok(shape)
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
