//! Triangulation of a cylinder closed by hemispheres.
//!
//! On the cylinder the triangulation is the convex hull of the vertices.

use crate::{Capsule, GenerateError};
use mesh::{SurfaceMesh, Vec3};
use std::f64::consts::{FRAC_PI_2, PI};

/// Ratio of the height of a regular triangle to its edge.
const HEIGHT: f64 = 0.866_025_403_784_438_6;

/// Ratio of the height of the seam to the edge.
///
/// The seam is the row of triangles between the zigzag end of the cylinder and the first circle of
/// a hemisphere.
const SEAM: f64 = 0.6;

/// Numbers of sample points, along the axis and around it, for the smallest edge on the wall.
const SAMPLES: (usize, usize) = (256, 24);

/// Smallest wanted edge length on the wall.
pub(super) fn smallest_edge(capsule: &Capsule, size: &dyn Fn(Vec3) -> f64) -> f64 {
    let (along, around) = SAMPLES;
    let half_extent = capsule.half_length + capsule.radius;
    let mut smallest = f64::INFINITY;
    for i in 0..=along {
        let x = half_extent * (2.0 * i as f64 / along as f64 - 1.0);
        for j in 0..around {
            let (sin, cos) = (2.0 * PI * j as f64 / around as f64).sin_cos();
            let out = Vec3::new(0.0, cos, sin) * capsule.radius;
            let at = capsule.centre + Vec3::x() * x + out;
            smallest = smallest.min(size(mesh::Surface::closest_point(capsule, at)));
        }
    }
    smallest
}

/// Triangulates the surface with edges of about the length `edge` everywhere.
///
/// The faces of the fluid's tets on the wall form the convex hull of the wall's vertices. The
/// convex hull of points on a cylinder joins points at neighbouring angles, however far apart they
/// are along the axis. The points therefore lie on straight lines along the cylinder, staggered
/// between neighbouring lines: the hull is then flat between two lines and consists of regular
/// triangles.
///
/// # Errors
/// [`GenerateError::TooManyVertices`] if more than `limit` vertices are needed.
pub(super) fn triangulate_capsule(
    capsule: &Capsule,
    edge: f64,
    limit: usize,
) -> Result<SurfaceMesh, GenerateError> {
    let radius = capsule.radius;
    let area = 4.0 * PI * radius * (radius + capsule.half_length);
    if area > HEIGHT * edge * edge * limit as f64 {
        return Err(GenerateError::TooManyVertices { limit });
    }
    // Neighbouring points on a circle of the cylinder are two lines apart.
    let on_circle = ((PI * radius / (HEIGHT * edge)).ceil() as usize).max(3);
    let rows = ((4.0 * capsule.half_length / edge).ceil() as usize).max(1);
    let angle = |line: usize| PI * line as f64 / on_circle as f64;
    let place = |x: f64, r: f64, theta: f64| {
        let (sin, cos) = theta.sin_cos();
        capsule.centre + Vec3::new(x, r * cos, r * sin)
    };
    let mut mesh = SurfaceMesh::default();
    for row in 0..=rows {
        let x = capsule.half_length * (2.0 * row as f64 / rows as f64 - 1.0);
        let points = (0..on_circle).map(|i| place(x, radius, angle(2 * i + row % 2)));
        mesh.points.extend(points);
    }
    // The point of a row on a line, modulo a full turn; a row has points on every second line.
    let at = |row: usize, line: usize| (row * on_circle + (line % (2 * on_circle)) / 2) as u32;
    let lines = 2 * on_circle;
    for row in 0..rows.saturating_sub(1) {
        // Each point has two triangles: with the next point on its own line and the points on the
        // neighbouring lines.
        for i in 0..on_circle {
            let line = 2 * i + row % 2;
            let (left, right) = (line + lines - 1, line + 1);
            let [own, next] = [at(row, line), at(row + 2, line)];
            mesh.triangles.push([own, at(row + 1, right), next]);
            mesh.triangles.push([own, next, at(row + 1, left)]);
        }
    }
    // The ends of the cylinder are zigzags of two rows with one point per line.
    for side in [-1.0, 1.0] {
        let zigzag: Vec<(f64, u32)> = (0..lines)
            .map(|line| {
                let outermost = if side < 0.0 { 0 } else { rows };
                let inner = if side < 0.0 { 1 } else { rows - 1 };
                let row = if line % 2 == outermost % 2 {
                    outermost
                } else {
                    inner
                };
                (angle(line), at(row, line))
            })
            .collect();
        cap(&mut mesh, capsule, side, edge, zigzag);
    }
    Ok(mesh)
}

/// Closes one end with circles of points from the seam to the pole, joined by strips of triangles.
fn cap(
    mesh: &mut SurfaceMesh,
    capsule: &Capsule,
    side: f64,
    edge: f64,
    mut below: Vec<(f64, u32)>,
) {
    let radius = capsule.radius;
    let circles = ((FRAC_PI_2 * radius - SEAM * edge) / (HEIGHT * edge))
        .round()
        .max(1.0) as usize;
    let first = SEAM * edge / radius;
    for k in 0..circles {
        let latitude = first + (FRAC_PI_2 - first) * k as f64 / circles as f64;
        let count = ((2.0 * PI * radius * latitude.cos() / edge).round() as usize).max(3);
        // Successive circles are rotated by half a step, so that their points are staggered.
        let rotation = PI * (k % 2) as f64 / count as f64;
        let circle: Vec<(f64, u32)> = (0..count)
            .map(|i| {
                let theta = rotation + 2.0 * PI * i as f64 / count as f64;
                let (sin, cos) = theta.sin_cos();
                let x = side * (capsule.half_length + radius * latitude.sin());
                let r = radius * latitude.cos();
                mesh.points
                    .push(capsule.centre + Vec3::new(x, r * cos, r * sin));
                (theta, mesh.points.len() as u32 - 1)
            })
            .collect();
        strip(&mut mesh.triangles, &below, &circle, side);
        below = circle;
    }
    mesh.points
        .push(capsule.centre + Vec3::x() * (side * (capsule.half_length + radius)));
    let pole = mesh.points.len() as u32 - 1;
    for (i, &(_, a)) in below.iter().enumerate() {
        let b = below[(i + 1) % below.len()].1;
        mesh.triangles.push(oriented([a, b, pole], side));
    }
}

/// Joins two closed circles of points, given with their ascending angles, by triangles.
fn strip(triangles: &mut Vec<[u32; 3]>, below: &[(f64, u32)], above: &[(f64, u32)], side: f64) {
    let point = |circle: &[(f64, u32)], i: usize| {
        let (angle, vertex) = circle[i % circle.len()];
        (angle + 2.0 * PI * (i / circle.len()) as f64, vertex)
    };
    let (mut i, mut j) = (0, 0);
    while i < below.len() || j < above.len() {
        let (a, b) = (point(below, i).1, point(above, j).1);
        // Advance on the circle whose next point has the smaller angle.
        let next = (point(below, i + 1), point(above, j + 1));
        let lower = j == above.len() || (i < below.len() && next.0.0 <= next.1.0);
        if lower {
            triangles.push(oriented([a, next.0.1, b], side));
            i += 1;
        } else {
            triangles.push(oriented([a, next.1.1, b], side));
            j += 1;
        }
    }
}

/// Orients a triangle of the end on `side` counterclockwise as seen from outside.
///
/// It is given as counterclockwise at the end of positive `x`.
fn oriented([a, b, c]: [u32; 3], side: f64) -> [u32; 3] {
    if side > 0.0 { [a, b, c] } else { [a, c, b] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::triangles::neighbours;
    use mesh::Surface;

    #[test]
    fn surface_is_closed_and_convex_on_the_cylinder() {
        for (half_length, edge) in [(3.0, 0.5), (5.0, 0.31), (0.4, 0.7)] {
            let capsule = Capsule::new(Vec3::new(0.25, -0.5, 1.0), 1.5, half_length);
            let mesh = triangulate_capsule(&capsule, edge, 100_000).unwrap();
            // The surface is closed and has the topology of a sphere.
            assert_eq!(neighbours(&mesh).len(), mesh.triangles.len());
            assert_eq!(mesh.triangles.len(), 2 * mesh.points.len() - 4);
            let mut volume = 0.0;
            for tri in &mesh.triangles {
                let [a, b, c] = tri.map(|v| mesh.points[v as usize]);
                let normal = (b - a).cross(&(c - a));
                volume += normal.dot(&(a - capsule.centre)) / 6.0;
                for longest in [a - b, b - c, c - a].map(|e| e.norm()) {
                    assert!(
                        longest < 1.6 * edge && longest > 0.4 * edge,
                        "{longest} {edge}"
                    );
                }
                let on_cylinder = |p: &Vec3| (p.x - capsule.centre.x).abs() <= half_length;
                if ![a, b, c].iter().all(on_cylinder) {
                    continue;
                }
                // No vertex lies outside the plane of the triangle.
                let normal = normal.normalize();
                for p in &mesh.points {
                    assert!(normal.dot(&(p - a)) < 1e-12, "{}", normal.dot(&(p - a)));
                }
            }
            let flat = 1.0 - volume / capsule.volume();
            assert!(
                flat > 0.0 && flat < (edge / capsule.radius).powi(2),
                "{flat}"
            );
            for p in &mesh.points {
                assert!(capsule.signed_distance(*p).abs() < 1e-14 * 10.0);
            }
        }
    }
}
