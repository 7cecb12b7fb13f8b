//! Triangulations of surfaces: designed where a sphere has one size, refined step by step where sizes vary.

use super::geodesic::{geodesic_sphere, triangles_for};
use super::refine::Refiner;
use crate::{MeshError, Surface, Vec3};
use std::collections::HashMap;

/// Sizes on one sphere that differ by less than this are served by one geodesic triangulation.
const UNIFORM: f64 = 1.25;

/// A closed triangulated surface, triangles counterclockwise as seen from outside the shape.
#[derive(Clone, Debug, Default)]
pub(super) struct SurfaceMesh {
    pub points: Vec<Vec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl SurfaceMesh {
    /// The triangle behind the edge opposite each vertex.
    pub fn neighbours(&self) -> Vec<[u32; 3]> {
        let mut left = HashMap::new();
        for (t, tri) in self.triangles.iter().enumerate() {
            for i in 0..3 {
                left.insert((tri[(i + 1) % 3], tri[(i + 2) % 3]), t as u32);
            }
        }
        self.triangles
            .iter()
            .map(|tri| [0, 1, 2].map(|i| left[&(tri[(i + 2) % 3], tri[(i + 1) % 3])]))
            .collect()
    }
}

/// The radius of `surface` if it is a sphere, which its volume tells.
pub(super) fn sphere_radius(surface: &dyn Surface) -> Option<f64> {
    let (_, radius) = surface.bounding_ball();
    let ball = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    // Rounding of a cube and a few products.
    ((surface.volume() - ball).abs() <= 1e-12 * ball).then_some(radius)
}

/// Triangulates `surface` with edges of length about `size(point)`.
///
/// # Errors
/// More than `limit` vertices would be needed, or splitting does not come to an end (spheroids more slender than 1 to 4).
pub(super) fn triangulate(
    name: &str,
    surface: &dyn Surface,
    size: &dyn Fn(Vec3) -> f64,
    limit: usize,
) -> Result<SurfaceMesh, MeshError> {
    let mut mesh = coarse(surface);
    let sizes = mesh.points.iter().map(|p| size(*p));
    let (low, high) = sizes.fold((f64::INFINITY, 0.0), |(l, h): (f64, f64), s| {
        (l.min(s), h.max(s))
    });
    if let Some(radius) = sphere_radius(surface) {
        let one_size = high <= UNIFORM * low;
        let edge = if one_size { (low * high).sqrt() } else { high };
        if triangles_for(edge / radius) > 2.0 * limit as f64 {
            return Err(MeshError::TooManyVertices { limit });
        }
        mesh = geodesic_sphere(edge / radius);
        for p in &mut mesh.points {
            *p = surface.centre() + radius * *p;
        }
        if one_size {
            return Ok(mesh);
        }
    }
    Refiner::new(mesh, name, surface, size).run(limit)
}

/// Triangulates the surface of the box between `min` and `max`, its edges and corners kept.
///
/// # Errors
/// More than `limit` vertices would be needed.
pub(super) fn triangulate_box(
    name: &str,
    surface: &dyn Surface,
    [min, max]: [Vec3; 2],
    size: &dyn Fn(Vec3) -> f64,
    limit: usize,
) -> Result<SurfaceMesh, MeshError> {
    // Corner `i` takes the upper bound of the axes whose bit is set.
    let points = (0..8usize)
        .map(|i| {
            Vec3::from_fn(|axis, _| {
                if i >> axis & 1 == 1 {
                    max[axis]
                } else {
                    min[axis]
                }
            })
        })
        .collect();
    let mut triangles = Vec::new();
    for [a, b, c, d] in [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ] {
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    Refiner::new(SurfaceMesh { points, triangles }, name, surface, size).run(limit)
}

/// 180 triangles between points whose normals are spread evenly: close together where the surface is curved most.
///
/// The closest point of a far point is the one whose normal points there.
fn coarse(surface: &dyn Surface) -> SurfaceMesh {
    let (centre, radius) = surface.bounding_ball();
    // Normals 0.4 apart, so that triangles are 0.4 radii of curvature long, below the 0.7 that any may have.
    let mut mesh = geodesic_sphere(0.4);
    for p in &mut mesh.points {
        // Far enough for the normal, near enough to lose few digits; the second projection restores them.
        let foot = surface.closest_point(centre + (1e4 * radius) * *p);
        *p = surface.closest_point(foot);
    }
    mesh
}
