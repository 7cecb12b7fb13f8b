//! Tets with all vertices on one surface: flat ones, and the side on which they are.

use super::odt::circumcentre;
use mesh::{Surface, TET_EDGES, Vec3};

/// Ratio of volume to cubed longest edge below which a tet is flat.
///
/// A regular tet has 0.118; four vertices of a wall whose edges are 0.4 of its radius of curvature
/// have at most 0.02.
const FLAT: f64 = 0.03;

/// Whether the volume of a tet is far below that of a regular tet with its longest edge.
pub(super) fn is_flat([a, b, c, d]: [Vec3; 4]) -> bool {
    let volume = (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 6.0;
    let edges = [b - a, c - a, d - a, c - b, d - b, d - c];
    let longest = edges.iter().fold(0.0, |m: f64, e| m.max(e.norm()));
    volume < FLAT * longest.powi(3)
}

/// Largest distance of the middle of an edge of a tet that lies in a curved surface from the
/// surface, as a fraction of its length.
///
/// Edges of one radius of curvature, the longest on any surface, rise by 0.13 of their length. An
/// edge between the two sides of a right angle is 0.2 or more away in its middle.
const RISE: f64 = 0.15;

/// Whether a tet with all vertices on a surface lies in it, and only exchanges the diagonal between
/// two of its triangles.
///
/// Such a tet is flat. Beside a sharp edge there are flat tets that do not lie in the surface, with
/// edges from one of its sides to the other.
pub(super) fn is_in_surface(surface: &dyn Surface, corners: [Vec3; 4]) -> bool {
    if !is_flat(corners) {
        return false;
    }
    let is_sharp = surface.closest_on_sharp_edges(corners[0]).is_some();
    let follows = |[i, j]: [usize; 2]| {
        let (a, b) = (corners[i], corners[j]);
        surface.signed_distance(0.5 * (a + b)).abs() <= RISE * (b - a).norm()
    };
    !is_sharp || TET_EDGES.into_iter().all(follows)
}

/// Whether a tet with all vertices on a surface that is not convex is inside the shape.
///
/// Its circumcentre is on the same side of the surface as the tet, if the surface is smooth. At a
/// sharp edge it may be on the other side, but all of the tet is on one side.
pub(super) fn is_behind(surface: &dyn Surface, corners: [Vec3; 4]) -> bool {
    let centroid = corners.iter().sum::<Vec3>() / 4.0;
    let point = match surface.closest_on_sharp_edges(centroid) {
        Some(_) => centroid,
        None => circumcentre(corners).0,
    };
    surface.signed_distance(point) < 0.0
}
