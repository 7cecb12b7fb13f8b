//! Geodesic triangulations of the unit sphere, from the icosahedron or the octahedron.
//!
//! Each face is divided into `T` triangles. The octahedron is used where symmetry planes cut
//! the sphere.

use mesh::{SurfaceMesh, Vec3};
use std::collections::HashMap;

/// Edge length of an equilateral triangle of area `4 pi / 20`.
///
/// The edges of a geodesic sphere are about this length over `sqrt(T)`.
const EDGE: f64 = 1.2045910058552547;

/// Largest allowed ratio of the edges to the wanted length.
const TOLERANCE: f64 = 1.12;

/// The coarsest geodesic triangulation of the unit sphere whose edges are at most 12 % longer than
/// `size`.
///
/// Only the classes with reflection symmetry are used (Caspar & Klug 1962): `T = b^2` and `T = 3
/// b^2`. They have the symmetry of the icosahedron with edges along the axes and are therefore
/// symmetric about the coordinate planes.
pub(super) fn geodesic_sphere(size: f64) -> SurfaceMesh {
    let (corners, faces) = icosahedron();
    let wanted = (EDGE / (TOLERANCE * size)).powi(2);
    let first = wanted.sqrt().ceil().max(1.0) as u32;
    let second = (wanted / 3.0).sqrt().ceil().max(1.0) as u32;
    if first * first <= 3 * second * second {
        subdivided(&corners, &faces, first)
    } else {
        root_three(&subdivided(&corners, &faces, second))
    }
}

/// Approximate number of triangles of [`geodesic_sphere`] for edges of length `size`.
pub(super) fn triangles_for(size: f64) -> f64 {
    20.0 * (EDGE / size).powi(2)
}

/// Edge length of an equilateral triangle of area `4 pi / 8`.
const OCTAHEDRAL_EDGE: f64 = 1.904_625_757_294_174_5;

/// The coarsest octahedral triangulation of the unit sphere whose edges are at most 12 % longer
/// than `size`.
///
/// No triangle crosses a coordinate plane; vertices on a plane have a coordinate of exactly zero.
/// Four triangles with right angles meet at each corner of the octahedron; smoothing evens out the
/// triangles around them.
pub(super) fn octahedral_sphere(size: f64) -> SurfaceMesh {
    let frequency = (OCTAHEDRAL_EDGE / (TOLERANCE * size)).ceil().max(1.0);
    let (corners, faces) = octahedron();
    subdivided(&corners, &faces, frequency as u32)
}

fn octahedron() -> ([Vec3; 6], [[usize; 3]; 8]) {
    let corners = [0, 1, 2, 3, 4, 5].map(|k: usize| {
        let mut corner = Vec3::zeros();
        corner[k / 2] = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
        corner
    });
    let faces = [0, 1, 2, 3, 4, 5, 6, 7].map(|k: usize| {
        let [x, y, z] = [k & 1, 2 + (k >> 1 & 1), 4 + (k >> 2 & 1)];
        // Each reflection reverses the orientation.
        if k.count_ones().is_multiple_of(2) {
            [x, y, z]
        } else {
            [x, z, y]
        }
    });
    (corners, faces)
}

fn icosahedron() -> ([Vec3; 12], [[usize; 3]; 20]) {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let v = Vec3::new;
    let corners = [
        v(0.0, 1.0, g),
        v(0.0, -1.0, g),
        v(0.0, 1.0, -g),
        v(0.0, -1.0, -g),
        v(1.0, g, 0.0),
        v(-1.0, g, 0.0),
        v(1.0, -g, 0.0),
        v(-1.0, -g, 0.0),
        v(g, 0.0, 1.0),
        v(g, 0.0, -1.0),
        v(-g, 0.0, 1.0),
        v(-g, 0.0, -1.0),
    ];
    // Three corners at a mutual distance of the edge length 2 form a face.
    let mut faces = [[0; 3]; 20];
    let mut n = 0;
    let near = |i: usize, j: usize| (corners[i] - corners[j]).norm() < 2.1;
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(k, i) {
                    let outward = corners[i].dot(&corners[j].cross(&corners[k])) > 0.0;
                    faces[n] = if outward { [i, j, k] } else { [i, k, j] };
                    n += 1;
                }
            }
        }
    }
    (corners.map(|c| c.normalize()), faces)
}

/// Regular polyhedron with every face divided into `frequency^2` triangles, projected onto the unit
/// sphere.
///
/// The point with barycentric coordinates `u_i` is in the direction of `sum_i sin(u_i w) x_i`,
/// where `w` is the angle between corners. This gives equal arcs along the edges (Shoemake 1985)
/// and nearly equal triangles between them.
fn subdivided(corners: &[Vec3], faces: &[[usize; 3]], frequency: u32) -> SurfaceMesh {
    let arc = corners[faces[0][0]].dot(&corners[faces[0][1]]).acos();
    let mut mesh = SurfaceMesh::default();
    let mut numbers: HashMap<[(usize, u32); 3], u32> = HashMap::new();
    for &face in faces {
        let mut number = |i: u32, j: u32| {
            let mut key = [(face[0], frequency - i - j), (face[1], i), (face[2], j)];
            // Points on an edge are identified by its two corners alone.
            for part in &mut key {
                if part.1 == 0 {
                    part.0 = usize::MAX;
                }
            }
            key.sort_unstable();
            *numbers.entry(key).or_insert_with(|| {
                let at: Vec3 = key
                    .iter()
                    .filter(|part| part.1 > 0)
                    .map(|part| {
                        corners[part.0] * (arc * f64::from(part.1) / f64::from(frequency)).sin()
                    })
                    .sum();
                mesh.points.push(at.normalize());
                mesh.points.len() as u32 - 1
            })
        };
        let mut triangles = Vec::new();
        for i in 0..frequency {
            for j in 0..frequency - i {
                triangles.push([number(i, j), number(i + 1, j), number(i, j + 1)]);
                if i + j + 1 < frequency {
                    triangles.push([number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)]);
                }
            }
        }
        mesh.triangles.append(&mut triangles);
    }
    mesh
}

/// Root-three subdivision of a triangulation.
///
/// The centre of every triangle becomes a point, and every edge is replaced by the edge between the
/// centres of its two triangles.
fn root_three(coarse: &SurfaceMesh) -> SurfaceMesh {
    let mut points = coarse.points.clone();
    let n = points.len() as u32;
    let mut left = HashMap::new();
    for (t, &[a, b, c]) in coarse.triangles.iter().enumerate() {
        let sum: Vec3 = [a, b, c].iter().map(|&v| coarse.points[v as usize]).sum();
        points.push(sum.normalize());
        for edge in [(a, b), (b, c), (c, a)] {
            left.insert(edge, n + t as u32);
        }
    }
    let mut triangles = Vec::with_capacity(3 * coarse.triangles.len());
    for &[a, b, c] in &coarse.triangles {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            triangles.push([a, left[&(b, a)], left[&(a, b)]]);
        }
    }
    SurfaceMesh {
        points,
        triangles,
        ..SurfaceMesh::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_euler_characteristic_and_orientation() {
        for size in [2.0, 0.8, 0.5, 0.4, 0.3, 0.172, 0.15] {
            let mesh = geodesic_sphere(size);
            let (v, f) = (mesh.points.len(), mesh.triangles.len());
            // V - E + F = 2 with 2 E = 3 F.
            assert_eq!(2 * v, f + 4, "size {size}");
            assert_eq!(f % 20, 0);
            let mean = EDGE / (f as f64 / 20.0).sqrt();
            assert!(mean <= TOLERANCE * size || f == 20);
            for t in &mesh.triangles {
                let [a, b, c] = t.map(|v| mesh.points[v as usize]);
                assert!(a.dot(&b.cross(&c)) > 0.0);
                let edges = [(a - b).norm(), (b - c).norm(), (c - a).norm()];
                let (lo, hi) = edges
                    .iter()
                    .fold((f64::MAX, 0f64), |(l, h), &e| (l.min(e), h.max(e)));
                // The worst triangle, in the family of the pentakis dodecahedron, is nearly
                // equilateral.
                assert!(hi < 1.25 * lo, "size {size}: {lo} {hi}");
            }
        }
    }

    #[test]
    fn sphere_is_symmetric_about_the_coordinate_planes() {
        let mesh = geodesic_sphere(0.3);
        assert_eq!(mesh.triangles.len(), 320);
        for p in &mesh.points {
            let image = Vec3::new(-p.x, p.y, p.z);
            assert!(mesh.points.iter().any(|q| (q - image).norm() < 1e-14));
        }
    }
}
