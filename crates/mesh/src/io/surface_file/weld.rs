//! Vertices from the corners of separate triangles.

use std::collections::HashMap;

use crate::{SurfaceMesh, Vec3};

/// Largest distance of corners that are one vertex, as a fraction of the extent of the surface.
///
/// Coordinates in single precision are rounded to 6e-8 of their size, and text files often have
/// six or seven digits.
const TOLERANCE: f64 = 1e-6;

/// Joins corners at nearly the same position; the first one of them is the vertex.
pub(super) fn weld(corners: &[[Vec3; 3]]) -> SurfaceMesh {
    let all = || corners.iter().flatten();
    let start = [Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY)];
    let [min, max] = all().fold(start, |[min, max], x| [min.inf(x), max.sup(x)]);
    let tolerance = TOLERANCE * (max - min).amax().max(f64::MIN_POSITIVE);
    let cell = |x: &Vec3| [0, 1, 2].map(|k| ((x[k] - min[k]) / tolerance).floor() as i64);
    let mut mesh = SurfaceMesh::default();
    let mut exact: HashMap<[u64; 3], u32> = HashMap::new();
    let mut vertices: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    for triangle in corners {
        mesh.triangles.push(triangle.map(|x| {
            // Adding zero makes the two zeros equal.
            let bits = [0, 1, 2].map(|k| (x[k] + 0.0).to_bits());
            *exact.entry(bits).or_insert_with(|| {
                let [i, j, k] = cell(&x);
                let around = (-1..=1).flat_map(|di| {
                    (-1..=1).flat_map(move |dj| (-1..=1).map(move |dk| [i + di, j + dj, k + dk]))
                });
                let near = around.filter_map(|cell| vertices.get(&cell)).flatten();
                let close = |v: &&u32| (mesh.points[**v as usize] - x).norm() <= tolerance;
                let found = near.copied().collect::<Vec<u32>>();
                if let Some(vertex) = found.iter().find(close) {
                    return *vertex;
                }
                let vertex = mesh.points.len() as u32;
                mesh.points.push(x);
                vertices.entry([i, j, k]).or_default().push(vertex);
                vertex
            })
        }));
    }
    mesh
}
