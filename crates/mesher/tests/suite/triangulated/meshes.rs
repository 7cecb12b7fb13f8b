//! Meshes around and inside surfaces of triangles.

use super::shapes::{cylinder, grid_box, grid_ellipsoid, meshed};
use super::{faceted, smooth};
use crate::{ball, curved};
use mesh::{LinearTets, Surface, TetMesh, Vec3};
use mesher::{
    Container, Ellipsoid, GenerateParams, MeshedBody, Placed, Sphere, Torus, TriangulatedSurface,
};
use nalgebra::Isometry3;
use std::collections::BTreeSet;

fn in_ball(bodies: &[MeshedBody<'_>]) -> (LinearTets, TetMesh) {
    in_container(bodies, &ball(8.0))
}

fn in_container(bodies: &[MeshedBody<'_>], container: &Container) -> (LinearTets, TetMesh) {
    let meshes = curved(bodies, container, &GenerateParams::default());
    meshes.unwrap_or_else(|error| panic!("{error}"))
}

fn body(surface: &dyn Surface, size: f64) -> MeshedBody<'_> {
    MeshedBody::new("body", surface, size)
}

/// Volume that the curved facets of a part enclose, by the divergence theorem on each.
fn enclosed(mesh: &TetMesh, part: &str) -> f64 {
    let tag = mesh.tag(part).unwrap();
    let of_part = mesh.facets().iter().filter(|facet| facet.tag == tag);
    // Three-point rule at the middles of the sides, on each of four flat parts.
    of_part
        .map(|facet| {
            let [a, b, c, ab, bc, ca] = facet.nodes.map(|v| mesh.points()[v as usize]);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
                .map(|[a, b, c]| a.dot(&b.cross(&c)) / 6.0)
                .iter()
                .sum::<f64>()
        })
        .sum()
}

/// The mesh around a file's surface has the size and quality of that around the shape itself, for
/// files finer and coarser than the mesh.
#[test]
fn meshes_around_an_ellipsoid_have_the_wanted_size() {
    let exact = Ellipsoid {
        semi_axes: Vec3::new(2.0, 1.0, 1.0),
    };
    let cells = |surface: &dyn Surface, size: f64| {
        let (_, mesh) = in_ball(&[body(surface, size)]);
        let quality = mesh.quality();
        assert!(
            quality.min_dihedral > 15.0 && quality.mean_quality > 0.85,
            "{quality:?}"
        );
        assert!(quality.min_jacobian > 0.3, "{quality:?}");
        mesh.n_cells() as f64
    };
    for size in [0.5, 0.25] {
        let wanted = cells(&exact, size);
        for file in [
            grid_ellipsoid(exact.semi_axes, 20),
            grid_ellipsoid(exact.semi_axes, 60),
            meshed(&exact, 0.3),
        ] {
            let found = cells(&smooth(file), size);
            assert!((found / wanted - 1.0).abs() < 0.15, "{found} {wanted}");
        }
    }
}

#[test]
fn bodies_with_sharp_edges_keep_them() {
    let sizes = [0.5, 0.3];
    for size in sizes {
        let cube = faceted(grid_box(Vec3::repeat(1.0), 2));
        let (_, mesh) = in_ball(&[body(&cube, size)]);
        // Facets of the cube lie in its faces.
        assert!((enclosed(&mesh, "body") + 8.0).abs() < 1e-9);
        let drum = smooth(cylinder(1.0, 1.0, 24, 3));
        let (_, mesh) = in_ball(&[body(&drum, size)]);
        let volume = -enclosed(&mesh, "body");
        assert!(
            (volume / drum.volume() - 1.0).abs() < 0.01 * size,
            "{volume}"
        );
        // The corners of both ends are on the rim or inside it.
        let tag = mesh.tag("body").unwrap();
        let on_rim = mesh.nodes_on(tag).into_iter().filter(|&node| {
            let x = mesh.points()[node as usize];
            (x.z.abs() - 1.0).abs() < 1e-9 && (x.xy().norm() - 1.0).abs() < 1e-3
        });
        assert!(on_rim.count() as f64 > 2.0 * 6.0 / size);
    }
}

/// A torus, whose surface is not the convex hull, and a step, which has a concave edge.
#[test]
fn bodies_that_are_not_convex() {
    let torus = Torus {
        radius: 2.0,
        tube: 0.7,
    };
    let surface = smooth(meshed(&torus, 0.3));
    let (_, mesh) = in_ball(&[body(&surface, 0.4)]);
    let volume = -enclosed(&mesh, "body");
    assert!((volume / torus.volume() - 1.0).abs() < 0.01, "{volume}");
    let step = faceted(step());
    let (_, mesh) = in_ball(&[body(&step, 0.3)]);
    assert!((enclosed(&mesh, "body") + 6.0).abs() < 1e-9);
}

/// Two units high over `0 <= x <= 1`, one unit over `1 <= x <= 2`, two units wide.
fn step() -> mesh::SurfaceMesh {
    let outline = [
        [0, 0],
        [2, 0],
        [2, 1],
        [1, 1],
        [1, 2],
        [0, 2],
        [0, 1],
        [1, 0],
    ];
    let mut mesh = mesh::SurfaceMesh::default();
    for z in [-1.0, 1.0] {
        let at = |[x, y]: [i32; 2]| Vec3::new(f64::from(x) - 0.8, f64::from(y) - 0.8, z);
        mesh.points.extend(outline.map(at));
    }
    // The order along the outline, of which 6 and 7 are in the middle of two sides.
    let ring = [0, 7, 1, 2, 3, 4, 5, 6];
    for k in 0..8 {
        let (a, b) = (ring[k], ring[(k + 1) % 8]);
        mesh.triangles.extend([[a, b, b + 8], [a, b + 8, a + 8]]);
    }
    for [a, b, c, d] in [[0, 7, 3, 6], [7, 1, 2, 3], [6, 3, 4, 5]] {
        mesh.triangles.extend([[a, c, b], [a, d, c]]);
        let [a, b, c, d] = [a, b, c, d].map(|v| v + 8);
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh
}

#[test]
fn containers_of_any_shape() {
    let sphere = Sphere::new(Vec3::new(0.1, 0.05, 0.0), 0.3);
    let check = |label: &str, surface: TriangulatedSurface, centre: Vec3| {
        let volume = surface.volume();
        let sphere = Sphere { centre, ..sphere };
        let container = Container::Surface(surface);
        let (_, mesh) = in_container(&[body(&sphere, 0.12)], &container);
        let found = mesh.volume() + sphere.volume();
        assert!(
            (found / volume - 1.0).abs() < 5e-3,
            "{label} {found} {volume}"
        );
        let quality = mesh.quality();
        assert!(
            quality.min_dihedral > 8.0 && quality.mean_quality > 0.8,
            "{label} {quality:?}"
        );
    };
    let inside = Vec3::new(0.1, 0.05, 0.0);
    check("cube", faceted(grid_box(Vec3::repeat(1.0), 1)), inside);
    check(
        "plate",
        smooth(grid_box(Vec3::new(2.0, 1.0, 0.5), 4)),
        inside,
    );
    check("drum", smooth(cylinder(1.0, 2.0, 24, 6)), inside);
    let ellipsoid = grid_ellipsoid(Vec3::new(2.0, 1.0, 1.0), 32);
    check("ellipsoid", smooth(ellipsoid), inside);
    check("step", faceted(step()), Vec3::new(-0.2, -0.3, 0.1));
    let torus = Torus {
        radius: 2.0,
        tube: 0.8,
    };
    check("torus", smooth(meshed(&torus, 0.3)), 2.0 * Vec3::y());
}

/// A faceted cylinder of 32 sides as container was refused as not recovered: its edges of 11
/// degrees were neither smooth nor sharp enough to tell on which side of the surface a tet is.
#[test]
fn bug_faceted_cylinders_were_not_recovered() {
    let sphere = Sphere::new(Vec3::new(0.3, -0.2, 0.7), 0.6);
    for (sides, rows, size) in [(32, 1, 0.15), (32, 4, 0.3), (48, 1, 0.5), (12, 4, 0.5)] {
        let container = Container::Surface(faceted(cylinder(2.0, 4.0, sides, rows)));
        let (_, mesh) = in_container(&[body(&sphere, size)], &container);
        // Facets follow the plane sides.
        let volume = enclosed(&mesh, Container::TAG);
        let exact = container.surface().volume();
        assert!((volume / exact - 1.0).abs() < 1e-9, "{sides} {volume}");
        let quality = mesh.quality();
        assert!(quality.mean_quality > 0.8, "{sides} {quality:?}");
    }
}

/// Faceted bodies beside each other: all of their edges are sharp.
#[test]
fn faceted_bodies_in_narrow_gaps() {
    let ball = faceted(grid_ellipsoid(Vec3::repeat(1.0), 12));
    let drum = faceted(cylinder(1.0, 1.0, 16, 2));
    let placed = [
        (
            ball,
            Isometry3::new(Vec3::zeros(), Vec3::new(0.3, 1.0, 0.2)),
        ),
        (
            drum,
            Isometry3::new(Vec3::new(1.6, 2.1, 0.0), Vec3::new(1.0, 0.3, 2.0)),
        ),
    ]
    .map(|(shape, pose)| Placed { shape, pose });
    for size in [0.2, 0.5] {
        let bodies =
            [("ball", &placed[0]), ("drum", &placed[1])].map(|(name, surface)| MeshedBody {
                name,
                surface,
                size,
            });
        let (_, mesh) = in_ball(&bodies);
        for body in bodies {
            let volume = -enclosed(&mesh, body.name);
            let exact = body.surface.volume();
            assert!(
                (volume / exact - 1.0).abs() < 1e-9,
                "{} {volume}",
                body.name
            );
        }
        let quality = mesh.quality();
        assert!(quality.mean_quality > 0.8, "{quality:?}");
    }
}

/// Vertices of a part relative to a point, as bits.
fn vertices(mesh: &LinearTets, tag: u16, centre: Vec3) -> BTreeSet<[u64; 3]> {
    let of_part = mesh.faces.iter().filter(|face| face.1 == tag);
    of_part
        .flat_map(|face| face.0)
        .map(|v| {
            let x = mesh.points[v as usize] - centre;
            [x.x, x.y, x.z].map(|c| (c + 0.0).to_bits())
        })
        .collect()
}

#[test]
fn equal_bodies_get_equal_surface_meshes() {
    let surface = smooth(grid_ellipsoid(Vec3::new(1.0, 0.5, 0.7), 24));
    let centres = [Vec3::new(-2.0, 0.5, 0.25), Vec3::new(1.75, 0.0, -0.5)];
    let rotation = Vec3::new(0.3, 0.4, 0.1);
    let placed = centres.map(|centre| Placed {
        shape: surface.clone(),
        pose: Isometry3::new(centre, rotation),
    });
    let bodies = [("a", &placed[0]), ("b", &placed[1])].map(|(name, surface)| MeshedBody {
        name,
        surface,
        size: 0.3,
    });
    let (tets, _) = in_ball(&bodies);
    assert_eq!(
        vertices(&tets, 0, centres[0]),
        vertices(&tets, 1, centres[1])
    );
}
