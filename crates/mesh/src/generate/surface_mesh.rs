//! Triangulations of surfaces: designed where a sphere has one size, refined step by step where sizes vary.

use super::geodesic::{geodesic_sphere, octahedral_sphere, triangles_for};
use super::planes::Planes;
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

/// Triangulates `surface` with edges of length about `size(point)`; no triangle crosses `planes`.
///
/// # Errors
/// More than `limit` vertices would be needed, or splitting does not come to an end (spheroids more slender than 1 to 4).
pub(super) fn triangulate(
    name: &str,
    surface: &dyn Surface,
    size: &dyn Fn(Vec3) -> f64,
    planes: Planes,
    limit: usize,
) -> Result<SurfaceMesh, MeshError> {
    let mut mesh = coarse(surface, planes);
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
        mesh = sphere(edge / radius, planes);
        for p in &mut mesh.points {
            *p = surface.centre() + radius * *p;
        }
        // The octahedron's triangles are of several shapes: smoothing is for them too.
        if one_size && planes.is_empty() {
            return Ok(mesh);
        }
    }
    Refiner::new(mesh, name, surface, size, planes).run(limit)
}

/// The unit sphere with edges of length `size`.
fn sphere(size: f64, planes: Planes) -> SurfaceMesh {
    if planes.is_empty() {
        geodesic_sphere(size)
    } else {
        octahedral_sphere(size)
    }
}

/// Triangulates the surface of the box between `min` and `max`, its edges and corners kept; no triangle crosses `planes`.
///
/// # Errors
/// More than `limit` vertices would be needed.
pub(super) fn triangulate_box(
    name: &str,
    surface: &dyn Surface,
    [min, max]: [Vec3; 2],
    size: &dyn Fn(Vec3) -> f64,
    planes: Planes,
    limit: usize,
) -> Result<SurfaceMesh, MeshError> {
    if !planes.is_empty() {
        let mesh = box_cut_by([min, max], planes);
        return Refiner::new(mesh, name, surface, size, planes).run(limit);
    }
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
    Refiner::new(
        SurfaceMesh { points, triangles },
        name,
        surface,
        size,
        planes,
    )
    .run(limit)
}

/// The surface of a box with every face cut along the planes that meet it.
fn box_cut_by([min, max]: [Vec3; 2], planes: Planes) -> SurfaceMesh {
    let ticks = [0, 1, 2].map(|axis| {
        if planes.0[axis] {
            vec![min[axis], 0.0, max[axis]]
        } else {
            vec![min[axis], max[axis]]
        }
    });
    let mut mesh = SurfaceMesh::default();
    let mut numbers: HashMap<[usize; 3], u32> = HashMap::new();
    for axis in 0..3 {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
        for side in [0, ticks[axis].len() - 1] {
            for j in 0..ticks[u].len() - 1 {
                for k in 0..ticks[v].len() - 1 {
                    let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[dj, dk]| {
                        let mut at = [0; 3];
                        (at[axis], at[u], at[v]) = (side, j + dj, k + dk);
                        *numbers.entry(at).or_insert_with(|| {
                            let place = |axis: usize| ticks[axis][at[axis]];
                            mesh.points.push(Vec3::new(place(0), place(1), place(2)));
                            mesh.points.len() as u32 - 1
                        })
                    });
                    mesh.triangles.extend(if side == 0 {
                        [[a, c, b], [a, d, c]]
                    } else {
                        [[a, b, c], [a, c, d]]
                    });
                }
            }
        }
    }
    mesh
}

/// 180 triangles between points whose normals are spread evenly: close together where the surface is curved most.
///
/// The closest point of a far point is the one whose normal points there.
fn coarse(surface: &dyn Surface, planes: Planes) -> SurfaceMesh {
    let (centre, radius) = surface.bounding_ball();
    // Normals 0.4 apart, so that triangles are 0.4 radii of curvature long, below the 0.7 that any may have.
    let mut mesh = sphere(0.4, planes);
    for p in &mut mesh.points {
        // Far enough for the normal, near enough to lose few digits; the second projection restores them.
        let foot = surface.closest_point(centre + (1e4 * radius) * *p);
        *p = planes.at(*p).along(surface.closest_point(foot));
    }
    mesh
}
