//! Tori.

use super::tube::{Section, closed_tube, intervals};
use mesh::{Surface, SurfaceMesh, Vec3};
use std::f64::consts::PI;

/// The torus about the x axis: the points at the distance `tube` from a circle about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Torus {
    /// Radius of the circle, larger than `tube`.
    pub radius: f64,
    /// Radius of the tube, positive.
    pub tube: f64,
}

impl Torus {
    /// Closest point of the circle; one of them for a point on the axis.
    fn on_circle(&self, point: Vec3) -> Vec3 {
        let out = Vec3::new(0.0, point.y, point.z);
        self.radius * out.try_normalize(0.0).unwrap_or_else(Vec3::y)
    }
}

impl Surface for Torus {
    fn signed_distance(&self, point: Vec3) -> f64 {
        (point - self.on_circle(point)).norm() - self.tube
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let foot = self.on_circle(point);
        // From a point of the circle all directions across it are equally short; one is chosen.
        let direction = (point - foot).try_normalize(0.0).unwrap_or_else(Vec3::x);
        foot + self.tube * direction
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        (Vec3::zeros(), self.radius + self.tube)
    }

    /// Pappus' theorem.
    fn volume(&self) -> f64 {
        2.0 * PI * self.radius * PI * self.tube.powi(2)
    }

    fn is_convex(&self) -> bool {
        false
    }

    fn reach(&self) -> f64 {
        self.tube.min(self.radius - self.tube)
    }

    fn inradius(&self) -> f64 {
        self.tube
    }

    fn triangulation(&self) -> Option<SurfaceMesh> {
        let length = 2.0 * PI * self.radius;
        // An even number, at least one section per 45 degrees of the hole.
        let count = 2 * intervals(0.5 * length, self.tube, 4);
        let sections: Vec<Section> = (0..count)
            .map(|k| {
                let (sin, cos) = (2.0 * PI * k as f64 / count as f64).sin_cos();
                let out = Vec3::new(0.0, cos, sin);
                Section {
                    centre: self.radius * out,
                    across: [out, -Vec3::x()],
                }
            })
            .collect();
        Some(closed_tube(self.tube, &sections))
    }
}
