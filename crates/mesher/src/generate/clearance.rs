//! Distance of a body from the wall around it.

use super::gap::closest_to_wall;
use crate::surface::sphere_radius;
use mesh::Surface;

/// Distance between the surface of a body and the wall of a container around it.
///
/// Negative if the body crosses the wall: minus how far the point found is outside. For spheres and
/// for convex containers it is the smallest distance. Otherwise the search begins at the vertex of
/// the body's triangulation closest to the wall, and finds the smallest distance from there.
pub fn clearance(body: &dyn Surface, wall: &dyn Surface) -> f64 {
    match sphere_radius(body) {
        Some(radius) => -wall.signed_distance(body.centre()) - radius,
        None => -wall.signed_distance(closest_to_wall(body, wall)),
    }
}
