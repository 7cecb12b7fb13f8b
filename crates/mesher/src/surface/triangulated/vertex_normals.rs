//! Normals at the corners of triangles, and the patches curved through them.

use super::patch::Patch;
use super::sharp_edges::SharpEdges;
use crate::surface::triangles;
use mesh::{SurfaceMesh, Vec3};

/// Smallest cosine between a corner's normal and that of its triangle; below it the corner counts
/// as the tip of a cone, at which edges are straight.
const TIP: f64 = 0.3;

/// The normal at each corner of each triangle; `None` at tips.
///
/// Corners of triangles with no sharp edge between them have the same normal: the sum of
/// `e_i x e_j / (|e_i| |e_j|)^2` over the triangles, with the edges from the vertex. It is exact
/// for vertices on a sphere (Max 1999).
pub(super) fn corner_normals(
    mesh: &SurfaceMesh,
    neighbours: &[[u32; 3]],
    sharp: &SharpEdges,
) -> Vec<[Option<Vec3>; 3]> {
    let mut normals = vec![[None; 3]; mesh.triangles.len()];
    let mut done = vec![[false; 3]; mesh.triangles.len()];
    for t in 0..mesh.triangles.len() {
        for i in 0..3 {
            if done[t][i] {
                continue;
            }
            // The triangles from here to a sharp edge on either side; all, if there is none.
            let fan: Vec<(usize, usize)> = triangles::fan(mesh, neighbours, t, i).collect();
            let ends_at = |k: usize| {
                let (t, i) = fan[k];
                sharp.of_triangles[t][(i + 1) % 3]
            };
            let first_end = (0..fan.len()).find(|&k| ends_at(k));
            let sector: Vec<(usize, usize)> = match first_end {
                None => fan,
                Some(end) => {
                    let start = (0..fan.len()).rev().find(|&k| ends_at(k)).unwrap_or(end);
                    fan[start + 1..]
                        .iter()
                        .chain(&fan[..=end])
                        .copied()
                        .collect()
                }
            };
            let weighted = sector.iter().map(|&(t, i)| {
                let [a, b, c] = rotated(mesh, t, i);
                let (u, v) = (b - a, c - a);
                u.cross(&v) / (u.norm_squared() * v.norm_squared())
            });
            let sum: Vec3 = weighted.sum();
            let normal = sum.try_normalize(0.0).filter(|normal| {
                sector.iter().all(|&(t, _)| {
                    let [a, b, c] = rotated(mesh, t, 0);
                    normal.dot(&(b - a).cross(&(c - a)).normalize()) > TIP
                })
            });
            for (t, i) in sector {
                normals[t][i] = normal;
                done[t][i] = true;
            }
        }
    }
    normals
}

/// Corners of a triangle, beginning with corner `i`.
fn rotated(mesh: &SurfaceMesh, t: usize, i: usize) -> [Vec3; 3] {
    let triangle = mesh.triangles[t];
    [0, 1, 2].map(|k| mesh.points[triangle[(i + k) % 3] as usize])
}

/// The patches through the corners with these normals and along the sharp edges.
pub(super) fn curved(
    mesh: &SurfaceMesh,
    normals: &[[Option<Vec3>; 3]],
    sharp: &SharpEdges,
) -> Vec<Patch> {
    let patch = |t: usize| {
        let triangle = mesh.triangles[t];
        let corners = rotated(mesh, t, 0);
        // Point of the edge from corner `i` to corner `j` next to corner `i`.
        let next_to = |[i, j]: [usize; 2]| {
            let arm = (corners[j] - corners[i]) / 3.0;
            match normals[t][i] {
                _ if sharp.of_triangles[t][3 - i - j] => {
                    sharp.next_to(mesh, triangle[i], triangle[j])
                }
                Some(normal) => corners[i] + arm - normal * normal.dot(&arm),
                None => corners[i] + arm,
            }
        };
        let ends = [[0, 1], [1, 0], [1, 2], [2, 1], [2, 0], [0, 2]];
        Patch::new(corners, ends.map(next_to))
    };
    (0..mesh.triangles.len()).map(patch).collect()
}

/// Flat patches.
pub(super) fn flat(mesh: &SurfaceMesh) -> Vec<Patch> {
    triangles::corners(mesh).map(Patch::flat).collect()
}
