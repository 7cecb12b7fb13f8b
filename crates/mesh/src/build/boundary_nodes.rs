//! Moving the boundary nodes of a mesh onto the true surfaces.

use std::collections::{BTreeMap, BTreeSet};
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
        let sharp = sharp_edges(points, facets, tag, surface);
        for facet in facets.iter().filter(|facet| facet.tag == tag) {
            for (i, &node) in facet
                .nodes
                .iter()
                .enumerate()
                .take(which.end)
                .skip(which.start)
            {
                let p = &mut points[node as usize];
                let closest = match sharp.contains(&node) {
                    true => surface.closest_on_sharp_edges(*p).unwrap_or(*p),
                    false => surface.closest_point(*p),
                };
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

/// Cosine between the normals of facets (25 degrees) above which their edge is not sharp.
const NOT_SHARP: f64 = 0.9;

/// Midside nodes of the edges that are on sharp edges of the surface.
///
/// The ends of such an edge are on sharp edges, and the normals of its two facets differ.
fn sharp_edges(
    points: &[Vec3],
    facets: &[Facet],
    tag: u16,
    surface: &dyn Surface,
) -> BTreeSet<u32> {
    let of_part = || facets.iter().filter(|facet| facet.tag == tag);
    let tolerance = SURFACE_TOLERANCE * surface.bounding_ball().1;
    let is_on_edge = |node: u32| {
        let p = points[node as usize];
        (surface.closest_on_sharp_edges(p)).is_some_and(|on| (on - p).norm() <= tolerance)
    };
    let Some(first) = of_part().next() else {
        return BTreeSet::new();
    };
    if (surface.closest_on_sharp_edges(points[first.nodes[0] as usize])).is_none() {
        return BTreeSet::new();
    }
    let vertices: BTreeSet<u32> = of_part()
        .flat_map(|facet| facet.nodes[..3].to_vec())
        .collect();
    let vertices: BTreeSet<u32> = vertices.into_iter().filter(|&v| is_on_edge(v)).collect();
    let mut normals: BTreeMap<u32, Vec3> = BTreeMap::new();
    let mut sharp = BTreeSet::new();
    for facet in of_part() {
        let [a, b, c] = [0, 1, 2].map(|i| points[facet.nodes[i] as usize]);
        let normal = (b - a).cross(&(c - a)).normalize();
        for i in 0..3 {
            let ends = [facet.nodes[i], facet.nodes[(i + 1) % 3]];
            if !ends.iter().all(|v| vertices.contains(v)) {
                continue;
            }
            let middle = facet.nodes[3 + i];
            if let Some(other) = normals.insert(middle, normal)
                && other.dot(&normal) < NOT_SHARP
            {
                sharp.insert(middle);
            }
        }
    }
    sharp
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
