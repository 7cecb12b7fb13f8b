//! Tori.

use std::f64::consts::{PI, TAU};

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};

use super::geometry::{Geometry, ShapeKeys, helix_points, outwards, placed};
use crate::error::SceneError;
use crate::keys::BodyFile;

/// A torus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TorusShape {
    /// Radius of the circle in the middle of the tube.
    pub radius: f64,
    /// Radius of the tube, smaller than the radius of the circle.
    pub tube_radius: f64,
    /// Axis of revolution in the initial configuration, a unit vector.
    pub axis: Vector3<f64>,
}

impl Geometry for TorusShape {
    fn keys() -> &'static [&'static str] {
        &["radius", "tube_radius", "axis", "orientation"]
    }

    fn read(keys: ShapeKeys) -> Result<Self, SceneError> {
        let shape = Self {
            radius: keys.radius(": a torus needs the radius of the circle in its tube")?,
            tube_radius: keys.tube_radius(": a torus needs the radius of its tube")?,
            axis: keys.axis()?,
        };
        if shape.tube_radius >= shape.radius {
            let what = "smaller than the radius of the torus, which would have no hole";
            return keys.must_be("tube_radius", what);
        }
        Ok(shape)
    }

    fn write(&self, file: &mut BodyFile) {
        (file.radius, file.tube_radius) = (Some(self.radius), Some(self.tube_radius));
    }

    fn lengths(&self) -> Vec<(&'static str, f64)> {
        vec![("radius", self.radius), ("tube_radius", self.tube_radius)]
    }

    fn axis(&self) -> Option<Vector3<f64>> {
        Some(self.axis)
    }

    fn moments_per_mass(&self) -> Option<Vector3<f64>> {
        let (large, small) = (
            self.radius * self.radius,
            self.tube_radius * self.tube_radius,
        );
        let across = large / 2.0 + 0.625 * small;
        Some(Vector3::new(large + 0.75 * small, across, across))
    }

    fn bounding_radius(&self) -> f64 {
        self.radius + self.tube_radius
    }

    fn size_radius(&self) -> f64 {
        self.tube_radius
    }

    fn volume(&self) -> f64 {
        TAU * PI * self.radius * self.tube_radius * self.tube_radius
    }

    fn centreline(&self) -> Vec<Vector3<f64>> {
        helix_points(
            &self.orientation(),
            [self.radius, self.tube_radius, 0.0, 1.0],
        )
    }

    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        self.radius * outwards(n) + self.tube_radius * n
    }

    fn transverse_support_distance(&self, _: &Vector3<f64>) -> f64 {
        self.radius + self.tube_radius
    }

    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        let torus = mesher::Torus {
            radius: self.radius / unit,
            tube: self.tube_radius / unit,
        };
        placed(pose, torus)
    }
}
