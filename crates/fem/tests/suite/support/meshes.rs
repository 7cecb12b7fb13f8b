//! Meshes of the shell between two concentric spheres and of a ball.

use std::collections::BTreeMap;

use mesh::{LinearTets, TetMesh, Vec3};
use mesher::Sphere;
use nalgebra::Matrix3;

use super::noise;

pub const BODY: u16 = 0;
pub const CONTAINER: u16 = 1;

/// Random affine image of [`straight_shell`] with outer radius 3 and displaced interior vertices.
///
/// The cells are affine and of all shapes. Each has a vertex in the interior; otherwise a Dirichlet
/// problem might not determine the pressure.
pub fn random_affine(n: usize, seed: u64) -> TetMesh {
    let mut tets = shell(n, 3.0);
    // Diagonally dominant, so never singular.
    let map = Matrix3::identity() + 0.3 * Matrix3::from_fn(|r, c| noise(seed, 3 * r + c));
    for (index, x) in tets.points.iter_mut().enumerate() {
        if x.norm() > 1.01 && x.norm() < 2.99 {
            // About a tenth of an edge in each direction.
            let step = 0.06 * x.norm() / n as f64;
            *x += Vec3::from_fn(|c, _| step * noise(seed, 9 + 3 * index + c));
        }
        *x = map * *x;
    }
    TetMesh::straight(tets).unwrap()
}

/// Shell between spheres of radius 1 and `outer` about the origin, with tags "sphere" and "outer".
///
/// Prisms over the triangles of an icosphere, `n` per edge of the icosahedron, in `n` layers in
/// geometric progression; each prism is split into three tetrahedra.
fn shell(n: usize, outer: f64) -> LinearTets {
    let (directions, triangles) = icosphere(n);
    let n_directions = directions.len() as u32;
    let mut points = Vec::new();
    for layer in 0..=n {
        let radius = outer.powf(layer as f64 / n as f64);
        points.extend(directions.iter().map(|d| radius * d));
    }
    let (mut tets, mut faces) = (Vec::new(), Vec::new());
    for triangle in triangles {
        let mut s = triangle;
        s.sort_unstable();
        for layer in 0..n as u32 {
            let [a, b, c] = s.map(|v| v + layer * n_directions);
            let [ta, tb, tc] = s.map(|v| v + (layer + 1) * n_directions);
            // The diagonal of a quadrilateral goes from the bottom at its lower direction number to
            // the top at its higher one.
            tets.extend([[a, b, c, tc], [a, b, tb, tc], [a, ta, tb, tc]]);
        }
        faces.push((triangle, BODY));
        faces.push((triangle.map(|v| v + n as u32 * n_directions), CONTAINER));
    }
    LinearTets {
        points,
        tets,
        faces,
        tags: vec!["sphere".into(), "outer".into()],
        ..LinearTets::default()
    }
}

/// [`shell`] with midside nodes on the spheres.
pub fn curved_shell(n: usize, outer: f64) -> TetMesh {
    let sphere = |radius| Sphere {
        centre: Vec3::zeros(),
        radius,
    };
    let (body, container) = (sphere(1.0), sphere(outer));
    TetMesh::curved(shell(n, outer), &[("sphere", &body), ("outer", &container)]).unwrap()
}

/// [`shell`] with straight edges.
pub fn straight_shell(n: usize, outer: f64) -> TetMesh {
    TetMesh::straight(shell(n, outer)).unwrap()
}

/// Ball of tetrahedra that share its centre, on an icosphere with `n` triangles per edge.
pub fn fan(n: usize) -> TetMesh {
    let (mut points, triangles) = icosphere(n);
    let centre = points.len() as u32;
    points.push(Vec3::zeros());
    let tets = triangles
        .iter()
        .map(|&[a, b, c]| [centre, a, b, c])
        .collect();
    let faces = triangles.into_iter().map(|face| (face, 0)).collect();
    TetMesh::straight(LinearTets {
        points,
        tets,
        faces,
        tags: vec!["surface".into()],
        ..LinearTets::default()
    })
    .unwrap()
}

/// Unit vectors and triangles of an icosphere: each edge of the icosahedron is divided into `n`.
fn icosphere(n: usize) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    let mut corners = Vec::new();
    for (a, b) in [
        (1.0, golden),
        (1.0, -golden),
        (-1.0, golden),
        (-1.0, -golden),
    ] {
        corners.extend([
            Vec3::new(0.0, a, b),
            Vec3::new(a, b, 0.0),
            Vec3::new(b, 0.0, a),
        ]);
    }
    let (mut points, mut triangles) = (Vec::new(), Vec::new());
    let mut numbers = BTreeMap::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                // The edge length for corners of this size is 2.
                let near = |a: usize, b: usize| (corners[a] - corners[b]).norm() < 2.1;
                if !(near(i, j) && near(j, k) && near(i, k)) {
                    continue;
                }
                let face = [i, j, k];
                let mut at = |a: usize, b: usize| {
                    let weights = [n - a - b, a, b];
                    let mut key = [0usize; 12];
                    for (corner, weight) in face.into_iter().zip(weights) {
                        key[corner] = weight;
                    }
                    *numbers.entry(key).or_insert_with(|| {
                        let sum: Vec3 = key
                            .iter()
                            .zip(&corners)
                            .map(|(&weight, x)| weight as f64 * x)
                            .sum();
                        points.push(sum.normalize());
                        points.len() as u32 - 1
                    })
                };
                for a in 0..n {
                    for b in 0..n - a {
                        triangles.push([at(a, b), at(a + 1, b), at(a, b + 1)]);
                        if a + b + 2 <= n {
                            triangles.push([at(a + 1, b), at(a + 1, b + 1), at(a, b + 1)]);
                        }
                    }
                }
            }
        }
    }
    (points, triangles)
}
