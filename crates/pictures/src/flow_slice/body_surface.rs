//! Triangulated surfaces of bodies, for pictures.

use std::collections::HashMap;

use mesh::SurfaceMesh;
use nalgebra::{Isometry3, Vector3};
use scene::Shape;

/// Number of triangles with which a smooth shape also looks smooth.
const SMOOTH_TRIANGLES: usize = 1200;

/// Largest distance of the middle of an edge from a smooth shape, over its extent from its centre:
/// half of the width of the outline in a picture.
const SMOOTH_DEVIATION: f64 = 2e-3;

/// Rounds of divisions where edges are farther away: each divides the distance by four.
const DIVISIONS: usize = 4;

/// Largest number of triangles; finer surfaces from files are coarsened.
const MAX_TRIANGLES: usize = 20_000;

/// Triangulated surface of a body in its initial orientation, centred at the origin; `None` for a
/// point.
///
/// Vertices of smooth shapes are on the exact surface. Triangles are counterclockwise as seen from
/// outside.
pub fn body_surface(shape: &Shape) -> Option<SurfaceMesh> {
    let surface = shape.surface(&Isometry3::identity(), 1.0)?;
    let mut mesh = (surface.triangulation()).unwrap_or_else(|| icosahedron(shape));
    if surface.has_fine_triangulation() {
        return Some(coarsened(mesh));
    }
    let onto = |x| surface.closest_point(x);
    while mesh.triangles.len() < SMOOTH_TRIANGLES {
        mesh = divided(&mesh, onto, 0.0);
    }
    let extent = mesh.points.iter().map(|x| x.norm()).fold(0.0, f64::max);
    for _ in 0..DIVISIONS {
        let finer = divided(&mesh, onto, SMOOTH_DEVIATION * extent);
        if finer.triangles.len() == mesh.triangles.len() || finer.triangles.len() > MAX_TRIANGLES {
            break;
        }
        mesh = finer;
    }
    Some(mesh)
}

/// An icosahedron whose vertices are moved onto a convex shape.
fn icosahedron(shape: &Shape) -> SurfaceMesh {
    let golden = 0.5 * (1.0 + 5f64.sqrt());
    // Corners of the regular icosahedron with edge 2.
    let corner = |k: usize| {
        let (axis, sign) = (k / 4, k % 4);
        let mut x = Vector3::zeros();
        x[axis] = if sign % 2 == 0 { 1.0 } else { -1.0 };
        x[(axis + 1) % 3] = if sign < 2 { golden } else { -golden };
        x
    };
    // The triangles are all triples of neighbours.
    let near = |i: usize, j: usize| ((corner(i) - corner(j)).norm() - 2.0).abs() < 1e-9;
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    let [a, b, c] = [i, j, k].map(corner);
                    let is_outward = (b - a).cross(&(c - a)).dot(&a) > 0.0;
                    let [j, k] = if is_outward { [j, k] } else { [k, j] };
                    triangles.push([i as u32, j as u32, k as u32]);
                }
            }
        }
    }
    let unit = nalgebra::UnitQuaternion::identity();
    let point = |k: usize| shape.support_point(&unit, &corner(k).normalize());
    SurfaceMesh {
        points: (0..12).map(point).collect(),
        triangles,
        ..SurfaceMesh::default()
    }
}

/// The mesh with the edges divided whose middles `onto` moves by at least a distance, onto the
/// surface, and with their triangles divided into two, three or four.
fn divided(
    mesh: &SurfaceMesh,
    onto: impl Fn(Vector3<f64>) -> Vector3<f64>,
    least: f64,
) -> SurfaceMesh {
    let mut points = mesh.points.clone();
    let mut middles = HashMap::new();
    let mut triangles = Vec::with_capacity(4 * mesh.triangles.len());
    for &[a, b, c] in &mesh.triangles {
        let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[i, j]| {
            *middles.entry([i.min(j), i.max(j)]).or_insert_with(|| {
                let middle = 0.5 * (mesh.points[i as usize] + mesh.points[j as usize]);
                let moved = onto(middle);
                let is_far = (moved - middle).norm() >= least;
                is_far.then(|| {
                    points.push(moved);
                    points.len() as u32 - 1
                })
            })
        });
        // Turned so that the divided edges come first.
        match [
            (a, b, c, [ab, bc, ca]),
            (b, c, a, [bc, ca, ab]),
            (c, a, b, [ca, ab, bc]),
        ]
        .into_iter()
        .max_by_key(|(.., [x, y, _])| (x.is_some(), y.is_some()))
        {
            Some((a, b, c, [Some(ab), Some(bc), Some(ca)])) => {
                triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
            Some((a, b, c, [Some(ab), Some(bc), None])) => {
                triangles.extend([[ab, b, bc], [a, ab, bc], [a, bc, c]]);
            }
            Some((a, b, c, [Some(ab), ..])) => triangles.extend([[a, ab, c], [ab, b, c]]),
            _ => triangles.push([a, b, c]),
        }
    }
    SurfaceMesh {
        points,
        triangles,
        ..SurfaceMesh::default()
    }
}

/// A surface of at most [`MAX_TRIANGLES`] triangles by vertex clustering (Rossignac & Borrel 1993).
///
/// All vertices in a cell of a grid are merged into the first of them.
fn coarsened(mesh: SurfaceMesh) -> SurfaceMesh {
    let mut coarse = mesh.clone();
    let mut cells = 96.0;
    while coarse.triangles.len() > MAX_TRIANGLES && cells > 4.0 {
        let corner = |sign: f64| {
            let infinite = Vector3::repeat(f64::NEG_INFINITY);
            mesh.points.iter().fold(infinite, |m, x| m.sup(&(sign * x)))
        };
        let (high, low) = (corner(1.0), -corner(-1.0));
        let side = (high - low).max() / cells;
        let (mut first, mut points) = (HashMap::new(), Vec::new());
        let new: Vec<u32> = (mesh.points.iter())
            .map(|x| {
                let cell = (x - low).map(|c| (c / side) as i64);
                *first.entry([cell.x, cell.y, cell.z]).or_insert_with(|| {
                    points.push(*x);
                    points.len() as u32 - 1
                })
            })
            .collect();
        let moved = mesh.triangles.iter().map(|t| t.map(|v| new[v as usize]));
        coarse = SurfaceMesh {
            triangles: moved
                .filter(|[a, b, c]| a != b && b != c && c != a)
                .collect(),
            points,
            ..SurfaceMesh::default()
        };
        cells *= 0.7;
    }
    coarse
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{
        CapsuleShape, DiskShape, EllipsoidShape, HelixShape, PointShape, SpheroidShape, TorusShape,
    };

    fn volume(mesh: &SurfaceMesh) -> f64 {
        let of = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|v| mesh.points[v as usize]);
            a.cross(&b).dot(&c) / 6.0
        };
        mesh.triangles.iter().map(of).sum()
    }

    /// The volume of a closed surface is right only if it is closed and turned outwards.
    #[test]
    fn surfaces_enclose_the_volumes_of_their_shapes() {
        let axis = Vector3::new(0.0, 0.6, 0.8);
        let orientation = Vector3::new(0.1, 0.7, -0.3);
        let tube = scene::Scene::parse(
            "bodies = [{ name = \"a\", shape = \"tube\", length = 8, radius = 0.5, \
             position = [0, 0, 0], orientation = [0.1, 0.7, -0.3] }]",
        )
        .unwrap();
        let shapes = [
            Shape::sphere(1.5),
            Shape::Ellipsoid(EllipsoidShape {
                semi_axes: Vector3::new(1.0, 0.4, 0.7),
                orientation,
            }),
            Shape::Spheroid(SpheroidShape {
                radius: 0.5,
                half_length: 1.0,
                axis,
            }),
            Shape::Capsule(CapsuleShape {
                radius: 0.2,
                half_length: 1.0,
                axis,
            }),
            Shape::Disk(DiskShape {
                radius: 1.0,
                half_length: 0.1,
                axis,
            }),
            Shape::Torus(TorusShape {
                radius: 1.0,
                tube_radius: 0.3,
                axis,
            }),
            Shape::Helix(HelixShape {
                radius: 0.3,
                tube_radius: 0.08,
                pitch: 1.0,
                turns: 2.0,
                orientation,
            }),
            tube.bodies()[0].shape.clone(),
        ];
        for shape in shapes {
            let mesh = body_surface(&shape).unwrap();
            let ratio = volume(&mesh) / shape.volume();
            // Facet geometry error: about (pi / e)^2 with e = 4 sqrt(n / 20) edges on a circle.
            assert!((0.93..1.001).contains(&ratio), "{shape:?}: {ratio}");
            assert!(mesh.triangles.len() <= MAX_TRIANGLES);
            // No edge is visibly off the surface: round ends of tubes were polygons.
            let surface = shape.surface(&Isometry3::identity(), 1.0).unwrap();
            let extent = mesh.points.iter().map(|x| x.norm()).fold(0.0, f64::max);
            for [a, b, c] in &mesh.triangles {
                for [i, j] in [[a, b], [b, c], [c, a]] {
                    let middle = 0.5 * (mesh.points[*i as usize] + mesh.points[*j as usize]);
                    let off = (surface.closest_point(middle) - middle).norm();
                    assert!(off < SMOOTH_DEVIATION * extent, "{shape:?}: {off}");
                }
            }
        }
        assert!(body_surface(&PointShape.into()).is_none());
    }

    #[test]
    fn a_surface_with_too_many_triangles_is_coarsened_and_stays_closed() {
        let mut fine = body_surface(&Shape::sphere(1.0)).unwrap();
        while fine.triangles.len() <= MAX_TRIANGLES {
            fine = divided(&fine, |x| x.normalize(), 0.0);
        }
        let coarse = coarsened(fine.clone());
        assert!(coarse.triangles.len() <= MAX_TRIANGLES);
        assert!((volume(&coarse) / volume(&fine) - 1.0).abs() < 0.05);
    }
}
