//! Spheres.

use mesh::{Surface, Vec3};

/// The sphere `|x - centre| = radius`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sphere {
    /// Centre.
    pub centre: Vec3,
    /// Radius, positive.
    pub radius: f64,
}

impl Sphere {
    /// The sphere with this centre and radius.
    pub const fn new(centre: Vec3, radius: f64) -> Self {
        Self { centre, radius }
    }
}

impl Surface for Sphere {
    fn signed_distance(&self, point: Vec3) -> f64 {
        (point - self.centre).norm() - self.radius
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        let arm = point - self.centre;
        let distance = arm.norm();
        // All points of the surface are equally close to the centre; one is chosen.
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

    fn is_convex(&self) -> bool {
        true
    }

    fn reach(&self) -> f64 {
        self.radius
    }
}

/// Radius of `surface` if it is a sphere, which is recognised by its volume.
pub(crate) fn sphere_radius(surface: &dyn Surface) -> Option<f64> {
    let (_, radius) = surface.bounding_ball();
    let ball = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    // Tolerance for the rounding of a cube and a few products.
    ((surface.volume() - ball).abs() <= 1e-12 * ball).then_some(radius)
}
