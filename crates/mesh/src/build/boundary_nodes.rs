//! Moving the boundary nodes of a mesh onto the true surfaces.

use std::ops::Range;

use crate::tet_mesh::{NamedSurface, find_tag};
use crate::{Facet, MeshError, Surface, Vec3};

/// Largest distance of a boundary vertex from its surface, as a fraction of the surface's radius.
///
/// Vertices in mesh files have the accuracy of CAD kernels, 1e-7 of the model's size
/// (`Precision::Confusion` of OpenCASCADE; Gmsh's own `Geometry.Tolerance` is 1e-8), and some of
/// them are in single precision (6e-8).
const SURFACE_TOLERANCE: f64 = 1e-6;

/// Moves the nodes with local numbers `which` of the facets of named parts onto their surfaces.
///
/// # Errors
/// [`MeshError::UnknownTag`]; [`MeshError::OffSurface`] for a vertex that is not close to its
/// surface, or a node that cannot be on two surfaces at once.
pub(super) fn project(
    points: &mut [Vec3],
    facets: &[Facet],
    which: Range<usize>,
    tags: &[String],
    surfaces: &[NamedSurface],
) -> Result<(), MeshError> {
    for &(name, surface) in surfaces {
        let tag = find_tag(tags, name)?;
        for facet in facets.iter().filter(|facet| facet.tag == tag) {
            for (i, &node) in facet
                .nodes
                .iter()
                .enumerate()
                .take(which.end)
                .skip(which.start)
            {
                let p = &mut points[node as usize];
                let closest = surface.closest_point(*p);
                if i < 3 {
                    check_distance(name, surface, *p, closest)?;
                }
                *p = closest;
            }
        }
    }
    // Where two named parts meet, the second projection must not have left the first surface.
    for &(name, surface) in surfaces {
        let tag = find_tag(tags, name)?;
        for facet in facets.iter().filter(|facet| facet.tag == tag) {
            for &node in &facet.nodes[which.clone()] {
                let p = points[node as usize];
                check_distance(name, surface, p, surface.closest_point(p))?;
            }
        }
    }
    Ok(())
}

/// Checks that `p` is within [`SURFACE_TOLERANCE`] of the surface.
///
/// # Errors
/// [`MeshError::OffSurface`].
fn check_distance(
    name: &str,
    surface: &dyn Surface,
    p: Vec3,
    closest: Vec3,
) -> Result<(), MeshError> {
    let allowed = SURFACE_TOLERANCE * surface.bounding_ball().1;
    let distance = (closest - p).norm();
    // Written so that NaN is refused.
    if distance <= allowed {
        return Ok(());
    }
    Err(MeshError::OffSurface {
        tag: name.into(),
        at: p.into(),
        distance,
        allowed,
    })
}
