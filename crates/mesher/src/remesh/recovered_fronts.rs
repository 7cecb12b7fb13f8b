//! Delaunay tets that have the given triangles as faces.

use super::front::Fronts;
use super::kept_cells::{FrontFace, KeptCells};
use crate::GenerateError;
use crate::delaunay::{carve, circumcentre, delaunay};
use crate::generate::layout::Layout;
use crate::generate::surface_refinement::circumcircle;
use mesh::{Vec3, dihedral_angles};
use rayon::prelude::*;

/// Largest radius, in longest edges of a triangle, of a ball from which vertices are removed.
///
/// The circumballs of well-shaped tets have 0.6; those of flat ones can have any radius.
const LARGEST_BALL: f64 = 1.5;

/// Smallest dihedral angle, in degrees, of tets with all vertices on given triangles.
///
/// Such tets cannot be improved by moving vertices.
const MIN_DIHEDRAL_ANGLE: f64 = 15.0;

/// A given triangle that is not a face of the tets, or is at a flat one.
#[derive(Clone, Copy)]
pub(super) struct BadFace {
    pub part: u32,
    pub face: FrontFace,
    /// Whether a vertex of another part is in the way.
    pub is_crowded: bool,
}

/// Delaunay tets, and what is wrong with them.
pub(super) struct Recovery {
    /// The tets in the fluid; `None` if given triangles are missing.
    pub tets: Option<Vec<[u32; 4]>>,
    /// Given triangles that are missing or, if there are none, those at flat tets.
    pub bad: Vec<BadFace>,
}

/// The Delaunay tets in the fluid.
///
/// Vertices inside the fluid that are in the way of triangles are removed from the layout.
///
/// # Errors
/// Those of [`delaunay`].
pub(super) fn recovered(
    layout: &mut Layout<'_>,
    fronts: &Fronts,
    kept: &KeptCells<'_>,
) -> Result<Recovery, GenerateError> {
    let given = layout.given_faces();
    let faces: Vec<(u32, &FrontFace)> = fronts.faces().collect();
    loop {
        let tets = delaunay(&layout.points, layout.centres.clone())?;
        let missing = match carve(layout.points.len(), tets, &given) {
            Ok(tets) => {
                let bad = at_flat_tets(layout, &tets, &given, &faces);
                return Ok(Recovery {
                    tets: Some(tets),
                    bad,
                });
            }
            Err(missing) => missing,
        };
        let mut in_the_way = Vec::new();
        let mut unexplained = Vec::new();
        for index in missing {
            let (part, face) = faces[index];
            let corners = given[index].map(|v| layout.points[v as usize]);
            let (centre, radius) = match face.behind {
                Some(cell) => {
                    let x = kept.placed_vertices(cell, part);
                    let (centre, _) = circumcentre(x);
                    (centre, (centre - x[0]).norm())
                }
                None => circumcircle(corners),
            };
            let longest = (0..3)
                .map(|i| (corners[i] - corners[(i + 1) % 3]).norm())
                .fold(0.0, f64::max);
            let is_inside = |p: &Vec3| (p - centre).norm_squared() <= radius * radius;
            let inside = || (0..layout.points.len()).filter(|&v| is_inside(&layout.points[v]));
            let before = in_the_way.len();
            if radius <= LARGEST_BALL * longest {
                in_the_way.extend(inside().filter(|&v| layout.free[v]));
            }
            if in_the_way.len() == before {
                // The vertices of the triangle and of its part may be inside by rounding.
                let is_crowded = inside().any(|v| !layout.free[v] && layout.owner[v] != part);
                unexplained.push(BadFace {
                    part,
                    face: *face,
                    is_crowded,
                });
            }
        }
        if in_the_way.is_empty() {
            return Ok(Recovery {
                tets: None,
                bad: unexplained,
            });
        }
        in_the_way.sort_unstable();
        in_the_way.dedup();
        layout.remove(&in_the_way);
    }
}

/// The given triangles at flat tets with all vertices on one given surface.
fn at_flat_tets(
    layout: &Layout<'_>,
    tets: &[[u32; 4]],
    given: &[[u32; 3]],
    faces: &[(u32, &FrontFace)],
) -> Vec<BadFace> {
    let is_flat = |tet: &&[u32; 4]| {
        let parts = tet.map(|v| layout.owner[v as usize]);
        let is_given = layout.is_given.get(parts[0] as usize) == Some(&true);
        is_given
            && parts.iter().all(|&part| part == parts[0])
            && dihedral_angles(tet.map(|v| layout.points[v as usize]))
                .iter()
                .any(|&angle| angle < MIN_DIHEDRAL_ANGLE)
    };
    let flat: Vec<&[u32; 4]> = tets.par_iter().filter(is_flat).collect();
    if flat.is_empty() {
        return Vec::new();
    }
    let at_flat = |face: &[u32; 3]| {
        // A flat tet between vertices of the surface may have no triangle of it, only edges.
        let shared = |tet: &[u32; 4]| face.iter().filter(|v| tet.contains(v)).count();
        flat.iter().any(|tet| shared(tet) >= 2)
    };
    (given.iter().zip(faces))
        .filter(|(corners, _)| at_flat(corners))
        .map(|(_, &(part, face))| BadFace {
            part,
            face: *face,
            is_crowded: false,
        })
        .collect()
}
