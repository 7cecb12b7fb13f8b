//! Disks with a round rim.

use super::tube::stretched_sphere;
use mesh::{Surface, SurfaceMesh, Vec3};
use std::f64::consts::PI;

/// The disk across the x axis: the points within `half_thickness` of a flat disc about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Disk {
    /// Radius including the rim, larger than `half_thickness`.
    pub radius: f64,
    /// Half the thickness and radius of the round rim, positive.
    pub half_thickness: f64,
}

impl Disk {
    /// Radius of the flat faces.
    fn flat(&self) -> f64 {
        self.radius - self.half_thickness
    }

    /// Closest point of the flat disc.
    fn on_disc(&self, point: Vec3) -> Vec3 {
        let across = Vec3::new(0.0, point.y, point.z);
        let r = across.norm();
        if r > self.flat() {
            across * (self.flat() / r)
        } else {
            across
        }
    }
}

impl Surface for Disk {
    fn signed_distance(&self, point: Vec3) -> f64 {
        (point - self.on_disc(point)).norm() - self.half_thickness
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let foot = self.on_disc(point);
        // From a point of the disc both faces are equally close; one is chosen.
        let direction = (point - foot).try_normalize(0.0).unwrap_or_else(Vec3::x);
        foot + self.half_thickness * direction
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        (Vec3::zeros(), self.radius)
    }

    /// A cylinder and, by Pappus' theorem, the half circle around it.
    fn volume(&self) -> f64 {
        let (r, t) = (self.flat(), self.half_thickness);
        2.0 * PI * r * r * t + PI * PI * r * t * t + 4.0 / 3.0 * PI * t.powi(3)
    }

    fn is_convex(&self) -> bool {
        true
    }

    fn reach(&self) -> f64 {
        self.half_thickness
    }

    fn curvature_size(&self, point: Vec3, factor: f64, growth: f64) -> f64 {
        // The rim lies at the distance `half_thickness` from the edge of the flat disc.
        let r = point.y.hypot(point.z);
        let to_rim = (point.x.hypot((r - self.flat()).min(0.0)) - self.half_thickness).max(0.0);
        let distance = to_rim.max(self.signed_distance(point));
        factor * self.half_thickness + growth * distance
    }

    fn triangulation(&self) -> Option<SurfaceMesh> {
        let axes = Vec3::new(self.half_thickness, self.radius, self.radius);
        let mut mesh = stretched_sphere(axes, 3);
        for p in &mut mesh.points {
            *p = self.closest_point(*p);
        }
        Some(mesh)
    }
}
