//! Disks.

use std::f64::consts::{PI, TAU};

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};

use super::geometry::{BALL, Geometry, MAX_RADIUS_PER_HALF_THICKNESS, ShapeKeys, outwards, placed};
use crate::error::SceneError;
use crate::keys::BodyFile;

/// A disk with a round rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskShape {
    /// Radius including the rim.
    pub radius: f64,
    /// Half of the thickness and radius of the rim, smaller than the radius.
    pub half_length: f64,
    /// Normal of the disk in the initial configuration, a unit vector.
    pub axis: Vector3<f64>,
}

impl Geometry for DiskShape {
    fn keys() -> &'static [&'static str] {
        &["radius", "half_length", "axis", "orientation"]
    }

    fn read(keys: ShapeKeys) -> Result<Self, SceneError> {
        let shape = Self {
            radius: keys.radius(": a disk needs its radius, rim included")?,
            half_length: keys.half_length(": a disk needs half its thickness")?,
            axis: keys.axis()?,
        };
        if shape.half_length >= shape.radius {
            return keys.must_be(
                "half_length",
                "smaller than the radius: it is half the thickness of the disk, whose rim is round",
            );
        }
        Ok(shape)
    }

    fn write(&self, file: &mut BodyFile) {
        (file.radius, file.half_length) = (Some(self.radius), Some(self.half_length));
    }

    fn lengths(&self) -> Vec<(&'static str, f64)> {
        vec![("radius", self.radius), ("half_length", self.half_length)]
    }

    fn axis(&self) -> Option<Vector3<f64>> {
        Some(self.axis)
    }

    fn bounding_radius(&self) -> f64 {
        self.radius
    }

    fn size_radius(&self) -> f64 {
        self.radius
            .min(MAX_RADIUS_PER_HALF_THICKNESS * self.half_length)
    }

    /// By Pappus' theorem: a cylinder of the radius `c` with half a circle of the radius `h` turned
    /// around it.
    fn volume(&self) -> f64 {
        let h = self.half_length;
        let c = self.radius - h;
        TAU * h * c * c + PI * PI * c * h * h + BALL * h.powi(3)
    }

    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        (self.radius - self.half_length) * outwards(n) + self.half_length * n
    }

    fn transverse_support_distance(&self, _: &Vector3<f64>) -> f64 {
        self.radius
    }

    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        let disk = mesher::Disk {
            radius: self.radius / unit,
            half_thickness: self.half_length / unit,
        };
        placed(pose, disk)
    }
}
