//! Self-intersections of triangulated surfaces.

use crate::surface::triangles;
use std::cmp::Ordering;

use rayon::prelude::*;

use super::Defect;
use crate::delaunay::orientation;
use mesh::{BoundingBox, BoxTree, SurfaceMesh, Vec3};

/// Refuses a surface of which two triangles without a common vertex touch, or two with one common
/// vertex meet elsewhere too.
///
/// Signs of volumes are exact (Shewchuk 1997).
pub(super) fn check(mesh: &SurfaceMesh) -> Result<(), Defect> {
    let boxes: Vec<_> = triangles::corners(mesh)
        .map(|corners| BoundingBox::around(&corners))
        .collect();
    let tree = BoxTree::new(boxes.iter().copied().enumerate());
    let first = (0..mesh.triangles.len())
        .into_par_iter()
        .filter_map(|t| {
            let mut first: Option<usize> = None;
            tree.visit_meeting(&boxes[t], |other| {
                let is_first = other > t && first.is_none_or(|first| other < first);
                if is_first && cross(mesh, t, other) {
                    first = Some(other);
                }
            });
            first.map(|other| (t, other))
        })
        .min();
    match first {
        None => Ok(()),
        Some((t, other)) => {
            let problem = format!(
                "intersects triangle {}: the surface passes through itself; separate the two parts",
                other + 1
            );
            Err(Defect::in_middle(mesh, t, problem))
        }
    }
}

/// Whether an edge of one triangle meets the other one away from common vertices.
fn cross(mesh: &SurfaceMesh, t: usize, u: usize) -> bool {
    let crossing = |t: usize, u: usize| {
        let (edges_of, plane) = (mesh.triangles[t], mesh.triangles[u]);
        (0..3).any(|i| {
            let edge = [edges_of[i], edges_of[(i + 1) % 3]];
            // Edges at a common vertex meet the triangle there.
            !edge.iter().any(|v| plane.contains(v))
                && meets(
                    edge.map(|v| mesh.points[v as usize]),
                    plane.map(|v| mesh.points[v as usize]),
                )
        })
    };
    crossing(t, u) || crossing(u, t)
}

/// Whether a segment meets a triangle, its boundary included; segments in its plane do not.
fn meets([p, q]: [Vec3; 2], [a, b, c]: [Vec3; 3]) -> bool {
    let side = |a, b, c, d| orientation(a, b, c, d).partial_cmp(&0.0);
    let (above, below) = (side(&a, &b, &c, &p), side(&a, &b, &c, &q));
    // Both ends on one side, or both in the plane.
    if above == below {
        return false;
    }
    let sides = [
        side(&p, &q, &a, &b),
        side(&p, &q, &b, &c),
        side(&p, &q, &c, &a),
    ];
    !(sides.contains(&Some(Ordering::Less)) && sides.contains(&Some(Ordering::Greater)))
}
