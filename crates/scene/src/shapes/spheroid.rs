//! Spheroids.

use mesh::Surface;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::ellipsoid;
use super::geometry::{BALL, Geometry, MAX_RADIUS_PER_HALF_THICKNESS, placed, shape_struct};

shape_struct! {
    /// A spheroid: prolate if `half_length > radius`, oblate if `half_length < radius`.
    SpheroidShape {
        /// Radius of the equator.
        radius: f64 = ": a spheroid needs the radius of its equator",
        /// Half of the length along the axis of revolution.
        half_length: f64 = ": a spheroid needs half its length along its axis",
        axis
    }
}

impl SpheroidShape {
    fn semi_axes(&self) -> Vector3<f64> {
        Vector3::new(self.half_length, self.radius, self.radius)
    }
}

impl Geometry for SpheroidShape {
    fn lengths(&self) -> Vec<(&'static str, f64)> {
        vec![("radius", self.radius), ("half_length", self.half_length)]
    }

    fn moments_per_mass(&self) -> Option<Vector3<f64>> {
        Some(ellipsoid::moments(self.semi_axes()))
    }

    fn bounding_radius(&self) -> f64 {
        self.radius.max(self.half_length)
    }

    fn size_radius(&self) -> f64 {
        self.radius
            .min(MAX_RADIUS_PER_HALF_THICKNESS * self.half_length)
    }

    fn volume(&self) -> f64 {
        BALL * self.radius * self.radius * self.half_length
    }

    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        ellipsoid::support_point(self.semi_axes(), n)
    }

    fn support_distance(
        &self,
        rotation: &UnitQuaternion<f64>,
        direction: &Vector3<f64>,
    ) -> Option<f64> {
        let along = (rotation * self.axis).dot(direction);
        let across = (1.0 - along * along).max(0.0).sqrt();
        Some((self.half_length * along).hypot(self.radius * across))
    }

    fn transverse_support_distance(&self, n: &Vector3<f64>) -> f64 {
        ellipsoid::transverse_support_distance(self.semi_axes(), n)
    }

    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        let semi_axes = self.semi_axes().map(|length| length / unit);
        placed(pose, mesher::Ellipsoid { semi_axes })
    }
}
