//! Corners and neighbours of the triangles of a surface.

use mesh::{SurfaceMesh, Vec3};
use std::collections::HashMap;

/// Corners of each triangle.
pub(crate) fn corners(mesh: &SurfaceMesh) -> impl Iterator<Item = [Vec3; 3]> {
    (mesh.triangles.iter()).map(|t| t.map(|v| mesh.points[v as usize]))
}

/// Centroid of a triangle.
pub(crate) fn centroid(mesh: &SurfaceMesh, t: usize) -> Vec3 {
    let corners = mesh.triangles[t].map(|v| mesh.points[v as usize]);
    corners.iter().sum::<Vec3>() / 3.0
}

/// For each triangle, the neighbours across the edges opposite its three vertices.
///
/// The surface must be closed and oriented.
pub(crate) fn neighbours(mesh: &SurfaceMesh) -> Vec<[u32; 3]> {
    let mut left = HashMap::new();
    for (t, tri) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            left.insert((tri[(i + 1) % 3], tri[(i + 2) % 3]), t as u32);
        }
    }
    (mesh.triangles.iter())
        .map(|tri| [0, 1, 2].map(|i| left[&(tri[(i + 2) % 3], tri[(i + 1) % 3])]))
        .collect()
}

/// The triangles around vertex `i` of triangle `t`, each with the place of the vertex in it.
///
/// Counterclockwise as seen from outside: the next triangle is the neighbour across the edge from
/// the vertex to the next vertex but one.
pub(crate) fn fan<'a>(
    mesh: &'a SurfaceMesh,
    neighbours: &'a [[u32; 3]],
    t: usize,
    i: usize,
) -> impl Iterator<Item = (usize, usize)> + 'a {
    let vertex = mesh.triangles[t][i];
    let next = move |&(here, slot): &(usize, usize)| {
        let next = neighbours[here][(slot + 1) % 3] as usize;
        let slot = mesh.triangles[next].iter().position(|v| *v == vertex)?;
        (next != t).then_some((next, slot))
    };
    std::iter::successors(Some((t, i)), next).take(mesh.triangles.len())
}

/// The same triangulation about another centre, with offsets from the centre rounded to `grid`.
pub(crate) fn translated(mesh: &SurfaceMesh, from: Vec3, to: Vec3, grid: f64) -> SurfaceMesh {
    let points = mesh.points.iter();
    let moved = points.map(|p| to + (p - from).map(|c| (c / grid).round() * grid));
    SurfaceMesh {
        points: moved.collect(),
        ..mesh.clone()
    }
}

/// Euler characteristic `V - E + F` of triangles: 2 for a sphere, 0 for a torus, 1 for a disc.
pub(crate) fn euler_characteristic(triangles: &[[u32; 3]]) -> isize {
    let mut vertices: Vec<u32> = triangles.iter().flatten().copied().collect();
    vertices.sort_unstable();
    vertices.dedup();
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    vertices.len() as isize - edges.len() as isize + triangles.len() as isize
}
