//! The interface between a shape and the mesh generator.

use crate::Vec3;

/// A smooth closed surface around which, or inside which, a mesh can be generated.
///
/// Also used to move boundary nodes onto the true surface. Distances are negative inside the shape
/// and positive outside it, for bodies and containers alike.
pub trait Surface: Sync {
    /// Signed distance from `point` to the surface, negative inside the shape.
    fn signed_distance(&self, point: Vec3) -> f64;

    /// Point of the surface closest to `point`.
    fn closest_point(&self, point: Vec3) -> Vec3;

    /// Centre and radius of a ball that contains the shape.
    fn bounding_ball(&self) -> (Vec3, f64);

    /// A point inside the shape with respect to which the shape is star-shaped.
    fn centre(&self) -> Vec3 {
        self.bounding_ball().0
    }

    /// Volume enclosed by the surface.
    fn volume(&self) -> f64;

    /// Smallest radius of curvature; it bounds the element size that can follow the surface.
    fn smallest_curvature_radius(&self) -> f64;

    /// Distance from `point` to the nearest point of largest curvature on the surface.
    ///
    /// Elements may grow with this distance.
    ///
    /// Zero, the default, stands for a surface of uniform curvature.
    fn distance_to_sharpest(&self, _point: Vec3) -> f64 {
        0.0
    }
}

/// Radius of `surface` if it is a sphere, which is recognised by its volume.
pub(crate) fn sphere_radius(surface: &dyn Surface) -> Option<f64> {
    let (_, radius) = surface.bounding_ball();
    let ball = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    // Tolerance for the rounding of a cube and a few products.
    ((surface.volume() - ball).abs() <= 1e-12 * ball).then_some(radius)
}
