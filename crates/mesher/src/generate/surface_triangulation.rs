//! Triangulation of surfaces: geodesic on spheres with one edge length, refined where it varies.

use super::geodesic::{geodesic_sphere, octahedral_sphere, triangles_for};
use super::surface_refinement::Refiner;
use super::symmetry_planes::SymmetryPlanes;
use crate::GenerateError;
use crate::surface::sphere_radius;
use mesh::{Surface, SurfaceMesh, Vec3};
use std::collections::HashMap;

/// Largest ratio of the wanted edge lengths on a sphere up to which one geodesic triangulation is
/// used.
const MAX_UNIFORM_RATIO: f64 = 1.25;

/// Triangulates `surface` with edges of length about `size(point)`; no triangle crosses `planes`.
///
/// # Errors
/// [`GenerateError::TooManyVertices`] if more than `limit` vertices are needed,
/// [`GenerateError::SurfaceNotRecovered`] if splitting does not end (spheroids more slender than 1
/// to 4).
pub(super) fn triangulate(
    name: &str,
    surface: &dyn Surface,
    size: &dyn Fn(Vec3) -> f64,
    planes: SymmetryPlanes,
    limit: usize,
) -> Result<SurfaceMesh, GenerateError> {
    let mut mesh = (surface.triangulation()).unwrap_or_else(|| coarse(surface, planes));
    let sizes = mesh.points.iter().map(|p| size(*p));
    let (low, high) = sizes.fold((f64::INFINITY, 0.0), |(l, h): (f64, f64), s| {
        (l.min(s), h.max(s))
    });
    if let Some(radius) = sphere_radius(surface) {
        let one_size = high <= MAX_UNIFORM_RATIO * low;
        let edge = if one_size { (low * high).sqrt() } else { high };
        if triangles_for(edge / radius) > 2.0 * limit as f64 {
            return Err(GenerateError::TooManyVertices { limit });
        }
        mesh = sphere(edge / radius, planes);
        for p in &mut mesh.points {
            *p = surface.centre() + radius * *p;
        }
        // The triangles of the octahedral sphere are uneven, so they are always smoothed.
        if one_size && planes.is_empty() {
            return Ok(mesh);
        }
    }
    Refiner::new(mesh, name, surface, size, planes).run(limit)
}

/// The unit sphere with edges of length `size`.
fn sphere(size: f64, planes: SymmetryPlanes) -> SurfaceMesh {
    if planes.is_empty() {
        geodesic_sphere(size)
    } else {
        octahedral_sphere(size)
    }
}

/// Triangulates the surface of the box between `min` and `max`, with its edges and corners.
///
/// No triangle crosses `planes`.
///
/// # Errors
/// [`GenerateError::TooManyVertices`] if more than `limit` vertices are needed.
pub(super) fn triangulate_box(
    name: &str,
    surface: &dyn Surface,
    [min, max]: [Vec3; 2],
    size: &dyn Fn(Vec3) -> f64,
    planes: SymmetryPlanes,
    limit: usize,
) -> Result<SurfaceMesh, GenerateError> {
    let mesh = coarse_box([min, max], planes);
    Refiner::new(mesh, name, surface, size, planes).run(limit)
}

/// The surface of a box with every face divided along the planes that meet it, two triangles per
/// rectangle.
///
/// The refinement depends on the order of points and triangles. The order without planes differs
/// from that with planes; both are kept, because another order would change the generated meshes.
fn coarse_box([min, max]: [Vec3; 2], planes: SymmetryPlanes) -> SurfaceMesh {
    let whole = planes.is_empty();
    let ticks = [0, 1, 2].map(|axis| {
        if planes.normal_to(axis) {
            vec![min[axis], 0.0, max[axis]]
        } else {
            vec![min[axis], max[axis]]
        }
    });
    let mut mesh = SurfaceMesh::default();
    let mut numbers: HashMap<[usize; 3], u32> = HashMap::new();
    let mut number = |at: [usize; 3]| {
        *numbers.entry(at).or_insert_with(|| {
            let coordinate = |axis: usize| ticks[axis][at[axis]];
            mesh.points
                .push(Vec3::new(coordinate(0), coordinate(1), coordinate(2)));
            mesh.points.len() as u32 - 1
        })
    };
    if whole {
        for corner in 0..8usize {
            number([0, 1, 2].map(|axis| corner >> axis & 1));
        }
    }
    for axis in if whole { [2, 1, 0] } else { [0, 1, 2] } {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        for side in [0, ticks[axis].len() - 1] {
            for j in 0..ticks[u].len() - 1 {
                for k in 0..ticks[v].len() - 1 {
                    let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[dj, dk]| {
                        let mut at = [0; 3];
                        (at[axis], at[u], at[v]) = (side, j + dj, k + dk);
                        number(at)
                    });
                    mesh.triangles.extend(match (side, whole) {
                        (0, true) => [[a, d, c], [a, c, b]],
                        (0, false) => [[a, c, b], [a, d, c]],
                        _ => [[a, b, c], [a, c, d]],
                    });
                }
            }
        }
    }
    mesh
}

/// A coarse triangulation, dense where the curvature is large.
///
/// It has 180 triangles (without symmetry planes) between points with evenly distributed normals.
///
/// The closest point of a point far away is the one whose normal points in its direction.
fn coarse(surface: &dyn Surface, planes: SymmetryPlanes) -> SurfaceMesh {
    let (centre, radius) = surface.bounding_ball();
    // Neighbouring normals differ by 0.4, so edges have 0.4 radii of curvature; at most 0.7 is
    // allowed.
    let mut mesh = sphere(0.4, planes);
    for p in &mut mesh.points {
        // Far enough to determine the normal, near enough to lose few digits, which the second
        // projection restores.
        let foot = surface.closest_point(centre + (1e4 * radius) * *p);
        *p = planes.at(*p).along(surface.closest_point(foot));
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Helix;

    /// Splits once travelled along the tube, a triangle per pass, until the passes were used up.
    #[test]
    fn a_long_thin_helix_is_triangulated_with_fine_edges() {
        let (tube, wanted) = (0.1, 0.028);
        let helix = Helix::new(1.0, 7.488_053_3, 2.0, tube);
        let planes = SymmetryPlanes::default();
        let mesh = triangulate("helix", &helix, &|_| wanted, planes, 1_000_000);
        let mesh = mesh.expect("the splitting ends");
        let ratio = |a: u32, b: u32| (mesh.points[a as usize] - mesh.points[b as usize]).norm();
        let edges = (mesh.triangles.iter()).flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let longest = edges.fold(0.0_f64, |most, [a, b]| most.max(ratio(a, b) / wanted));
        // The square root of two, and a percent for each pass that is not strict.
        assert!(longest < 1.7, "{longest}");
    }
}
