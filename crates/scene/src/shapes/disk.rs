//! Disks.

use std::f64::consts::{PI, TAU};

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};

use super::geometry::{
    BALL, Geometry, MAX_RADIUS_PER_HALF_THICKNESS, outwards, placed, shape_struct,
};

shape_struct! {
    /// A disk with a round rim.
    DiskShape {
        /// Radius including the rim.
        radius: f64 = ": a disk needs its radius, rim included",
        /// Half of the thickness and radius of the rim, smaller than the radius.
        half_length: f64 = ": a disk needs half its thickness",
        axis
    }
}

impl Geometry for DiskShape {
    fn problem(&self) -> Option<(&'static str, String)> {
        let bound =
            "smaller than the radius: it is half the thickness of the disk, whose rim is round";
        (self.half_length >= self.radius).then(|| ("half_length", bound.to_owned()))
    }

    fn lengths(&self) -> Vec<(&'static str, f64)> {
        vec![("radius", self.radius), ("half_length", self.half_length)]
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
