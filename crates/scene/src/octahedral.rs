//! Triangulations of surfaces with one point in each direction from their centre.

use std::f64::consts::FRAC_PI_2;

use mesh::SurfaceMesh;
use nalgebra::Vector3;

/// Largest length of the edges of a coarse triangulation, over the reach: half a radius of
/// curvature, like the coarse triangulations of other shapes.
const COARSE_EDGE: f64 = 0.5;

/// Largest number of edges along a quarter of a meridian in a coarse triangulation.
const MAX_COARSE_EDGES: f64 = 64.0;

/// The octants of a sphere divided into triangles, with the points of directions.
///
/// No triangle crosses a coordinate plane, which may be a symmetry plane.
pub(crate) fn octahedral(
    divisions: usize,
    point: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    let mut numbers = std::collections::HashMap::new();
    let n = divisions as i64;
    let mut vertex = |mesh: &mut SurfaceMesh, at: [i64; 3]| -> u32 {
        *numbers.entry(at).or_insert_with(|| {
            let direction = Vector3::from(at.map(|x| x as f64)).normalize();
            mesh.points.push(point(direction));
            mesh.points.len() as u32 - 1
        })
    };
    for octant in 0..8 {
        let signs = [0, 1, 2].map(|axis| if octant >> axis & 1 == 0 { 1 } else { -1 });
        // The orientation of an octant changes with each sign.
        let flips = signs.iter().product::<i64>() < 0;
        for i in 0..n {
            for j in 0..n - i {
                let mut add = |corners: [[i64; 2]; 3]| {
                    let mut triangle = corners.map(|[a, b]| {
                        let at = [signs[0] * a, signs[1] * b, signs[2] * (n - a - b)];
                        vertex(&mut mesh, at)
                    });
                    if flips {
                        triangle.swap(1, 2);
                    }
                    mesh.triangles.push(triangle);
                };
                add([[i, j], [i + 1, j], [i, j + 1]]);
                if i + j + 2 <= n {
                    add([[i + 1, j], [i + 1, j + 1], [i, j + 1]]);
                }
            }
        }
    }
    mesh
}

/// A coarse triangulation of a surface of this size and reach, with the points of directions.
pub(crate) fn coarse(
    radius: f64,
    reach: f64,
    point: impl Fn(Vector3<f64>) -> Vector3<f64>,
) -> SurfaceMesh {
    let edges = FRAC_PI_2 * radius / (COARSE_EDGE * reach);
    octahedral(edges.ceil().clamp(4.0, MAX_COARSE_EDGES) as usize, point)
}
