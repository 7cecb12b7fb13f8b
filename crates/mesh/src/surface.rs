//! Smooth closed surfaces of bodies and containers.

use crate::Vec3;

/// A smooth closed surface: what the generator and the curving of midside nodes need to know of a shape.
///
/// Distances are negative inside the shape and positive outside it, for bodies and containers alike.
pub trait Surface: Sync {
    /// Signed distance from `point` to the surface, negative inside the shape.
    fn signed_distance(&self, point: Vec3) -> f64;

    /// The point of the surface closest to `point`.
    fn closest_point(&self, point: Vec3) -> Vec3;

    /// Centre and radius of a ball that contains the shape.
    fn bounding_ball(&self) -> (Vec3, f64);

    /// A point inside the shape from which every point of the surface can be seen.
    fn centre(&self) -> Vec3 {
        self.bounding_ball().0
    }

    /// Volume enclosed by the surface.
    fn volume(&self) -> f64;

    /// Smallest radius of curvature, which bounds the element size that can follow the surface.
    fn smallest_curvature_radius(&self) -> f64;
}

/// The sphere `|x - centre| = radius`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre.
    pub centre: Vec3,
    /// Radius, positive.
    pub radius: f64,
}

impl Surface for Sphere {
    fn signed_distance(&self, point: Vec3) -> f64 {
        (point - self.centre).norm() - self.radius
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let arm = point - self.centre;
        let distance = arm.norm();
        // The centre is equally far from every point: any of them is closest.
        let direction = if distance > 0.0 {
            arm / distance
        } else {
            Vec3::x()
        };
        self.centre + self.radius * direction
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        (self.centre, self.radius)
    }

    fn volume(&self) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.radius.powi(3)
    }

    fn smallest_curvature_radius(&self) -> f64 {
        self.radius
    }
}
