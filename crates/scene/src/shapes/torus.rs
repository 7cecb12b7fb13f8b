//! Tori.

use std::f64::consts::{PI, TAU};

use mesh::Surface;
use nalgebra::{Isometry3, Vector3};

use super::geometry::{Geometry, ShapeFile, helix_points, outwards, placed, shape_struct};

shape_struct! {
    /// A torus.
    TorusShape {
        /// Radius of the circle in the middle of the tube.
        radius: f64 = ": a torus needs the radius of the circle in its tube",
        /// Radius of the tube, smaller than the radius of the circle.
        tube_radius: f64 = ": a torus needs the radius of its tube",
        axis
    }
}

impl Geometry for TorusShape {
    fn problem(&self) -> Option<(&'static str, String)> {
        let bound = "smaller than the radius of the torus, which would have no hole";
        (self.tube_radius >= self.radius).then(|| ("tube_radius", bound.to_owned()))
    }

    fn lengths(&self) -> Vec<(&'static str, f64)> {
        vec![("radius", self.radius), ("tube_radius", self.tube_radius)]
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

    fn centreline(&self) -> Vec<(Vector3<f64>, f64)> {
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
