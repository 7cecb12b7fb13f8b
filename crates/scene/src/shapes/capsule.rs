//! Capsules.

use std::f64::consts::TAU;

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};

use super::geometry::{BALL, Geometry, placed, shape_struct};

shape_struct! {
    /// A cylinder closed by hemispheres.
    CapsuleShape {
        /// Radius of the cylinder and of the hemispheres.
        radius: f64 = ": a capsule needs the radius of its cylinder",
        /// Half of the length including the hemispheres, larger than the radius.
        half_length: f64 = ": a capsule needs half its length, round ends included",
        axis
    }
}

impl Geometry for CapsuleShape {
    fn problem(&self) -> Option<(&'static str, String)> {
        let bound = "larger than the radius: it includes the round ends; use shape = \"sphere\" for \
                     equal lengths";
        (self.half_length <= self.radius).then(|| ("half_length", bound.to_owned()))
    }

    fn lengths(&self) -> Vec<(&'static str, f64)> {
        vec![("radius", self.radius), ("half_length", self.half_length)]
    }

    fn moments_per_mass(&self) -> Option<Vector3<f64>> {
        // A cylinder of the half length `h`, and two half balls with their centres of mass 3/8 r
        // beyond its ends.
        let r = self.radius;
        let h = self.half_length - r;
        let (cylinder, ball) = (2.0 * h, 4.0 / 3.0 * r);
        let along = cylinder * r * r / 2.0 + ball * 0.4 * r * r;
        let of_balls = 0.4 * r * r + h * h + 0.75 * h * r;
        let across = cylinder * (r * r / 4.0 + h * h / 3.0) + ball * of_balls;
        Some(Vector3::new(along, across, across) / (cylinder + ball))
    }

    fn bounding_radius(&self) -> f64 {
        self.half_length
    }

    fn size_radius(&self) -> f64 {
        self.radius
    }

    fn volume(&self) -> f64 {
        let Self {
            radius,
            half_length,
            ..
        } = self;
        BALL * radius.powi(3) + TAU * radius * radius * (half_length - radius)
    }

    fn support_point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        Vector3::x() * (self.half_length - self.radius).copysign(n.x) + self.radius * n
    }

    fn transverse_support_distance(&self, n: &Vector3<f64>) -> f64 {
        (self.half_length - self.radius) * n.y.hypot(n.z) + self.radius
    }

    fn surface(&self, pose: Isometry3<f64>, unit: f64) -> Option<Box<dyn Surface>> {
        let capsule = mesher::Capsule {
            centre: Vector3::zeros(),
            radius: self.radius / unit,
            half_length: (self.half_length - self.radius) / unit,
        };
        placed(pose, capsule)
    }
}
