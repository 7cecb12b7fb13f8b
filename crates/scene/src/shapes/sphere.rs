//! Spheres.

use mesh::Surface;
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use super::ellipsoid;
use super::geometry::{BALL, Geometry, shape_struct};

shape_struct! {
    /// A sphere.
    SphereShape {
        /// Radius.
        radius: f64 = ": a sphere needs a radius",
    }
}

impl Geometry for SphereShape {
    fn lengths(&self) -> Vec<(&'static str, f64)> {
        vec![("radius", self.radius)]
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn moments_per_mass(&self) -> Option<Vector3<f64>> {
        Some(ellipsoid::moments(Vector3::repeat(self.radius)))
    }

    fn bounding_radius(&self) -> f64 {
        self.radius
    }

    fn size_radius(&self) -> f64 {
        self.radius
    }

    fn volume(&self) -> f64 {
        BALL * self.radius.powi(3)
    }

    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        self.radius * n
    }

    fn support_distance(&self, _: &UnitQuaternion<f64>, _: &Vector3<f64>) -> Option<f64> {
        Some(self.radius)
    }

    fn transverse_support_distance(&self, _: &Vector3<f64>) -> f64 {
        self.radius
    }

    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        // Rotations do not change it.
        Some(Box::new(mesher::Sphere {
            centre: pose.translation.vector,
            radius: self.radius / unit,
        }))
    }
}
