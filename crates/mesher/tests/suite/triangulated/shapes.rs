//! Triangulations for tests.

use mesh::{Surface, SurfaceMesh, Vec3};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// An ellipsoid by circles of latitude about the z axis with `n` points each, as CAD programs make
/// them.
pub fn grid_ellipsoid(semi_axes: Vec3, n: usize) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    let rows = n / 2;
    let at = |row: usize, k: usize| (1 + (row - 1) * n + k % n) as u32;
    mesh.points.push(-Vec3::z());
    for row in 1..rows {
        let (sin, cos) = (PI * row as f64 / rows as f64).sin_cos();
        for k in 0..n {
            let angle = 2.0 * PI * k as f64 / n as f64;
            mesh.points
                .push(Vec3::new(sin * angle.cos(), sin * angle.sin(), -cos));
        }
    }
    mesh.points.push(Vec3::z());
    let pole = mesh.points.len() as u32 - 1;
    for k in 0..n {
        mesh.triangles.push([0, at(1, k + 1), at(1, k)]);
        mesh.triangles
            .push([pole, at(rows - 1, k), at(rows - 1, k + 1)]);
        for row in 1..rows - 1 {
            let (a, b) = (at(row, k), at(row, k + 1));
            let (c, d) = (at(row + 1, k), at(row + 1, k + 1));
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    for p in &mut mesh.points {
        p.component_mul_assign(&semi_axes);
    }
    mesh
}

/// The faces on a shape in a generated mesh.
pub fn meshed(shape: &dyn Surface, size: f64) -> SurfaceMesh {
    let (centre, radius) = shape.bounding_ball();
    let container = Container::Ball(Sphere::new(centre, 4.0 * radius));
    let body = MeshedBody::new("body", shape, size);
    let tets = generate(&[body], &container, &GenerateParams::default())
        .unwrap()
        .mesh;
    let mut numbers = BTreeMap::new();
    let mut mesh = SurfaceMesh::default();
    for (face, _) in tets.faces.iter().filter(|face| face.1 == 0) {
        // Faces are oriented out of the fluid.
        let triangle = [face[0], face[2], face[1]].map(|v| {
            *numbers.entry(v).or_insert_with(|| {
                mesh.points.push(tets.points[v as usize]);
                mesh.points.len() as u32 - 1
            })
        });
        mesh.triangles.push(triangle);
    }
    mesh
}

/// The box `[-1, 1]^3` stretched by `half`, each face divided into `n^2` squares.
pub fn grid_box(half: Vec3, n: usize) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    let mut numbers = BTreeMap::new();
    let mut number = |mesh: &mut SurfaceMesh, at: [usize; 3]| {
        *numbers.entry(at).or_insert_with(|| {
            let unit = Vec3::from(at.map(|k| 2.0 * k as f64 / n as f64 - 1.0));
            mesh.points.push(unit.component_mul(&half));
            mesh.points.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, n] {
            for j in 0..n {
                for k in 0..n {
                    let corners = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[dj, dk]| {
                        let mut at = [side; 3];
                        at[(axis + 1) % 3] = j + dj;
                        at[(axis + 2) % 3] = k + dk;
                        number(&mut mesh, at)
                    });
                    let [a, b, c, d] = corners;
                    mesh.triangles.extend(match side {
                        0 => [[a, c, b], [a, d, c]],
                        _ => [[a, b, c], [a, c, d]],
                    });
                }
            }
        }
    }
    mesh
}

/// A cylinder about the z axis with flat ends: `n` segments around, `rows` along it.
pub fn cylinder(radius: f64, half_length: f64, n: usize, rows: usize) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    let at = |row: usize, k: usize| (2 + row * n + k % n) as u32;
    mesh.points
        .extend([-half_length * Vec3::z(), half_length * Vec3::z()]);
    for row in 0..=rows {
        let z = half_length * (2.0 * row as f64 / rows as f64 - 1.0);
        for k in 0..n {
            let (sin, cos) = (2.0 * PI * k as f64 / n as f64).sin_cos();
            mesh.points.push(Vec3::new(radius * cos, radius * sin, z));
        }
    }
    for k in 0..n {
        mesh.triangles.push([0, at(0, k + 1), at(0, k)]);
        mesh.triangles.push([1, at(rows, k), at(rows, k + 1)]);
        for row in 0..rows {
            let (a, b) = (at(row, k), at(row, k + 1));
            let (c, d) = (at(row + 1, k), at(row + 1, k + 1));
            mesh.triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    mesh
}
