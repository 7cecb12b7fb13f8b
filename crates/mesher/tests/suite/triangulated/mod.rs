//! Surfaces of triangles: distances, meshes around and inside them, files, and what is refused.

mod files;
mod malformed;
mod meshes;
pub mod shapes;

use approx::assert_relative_eq;
use mesh::{Surface, SurfaceMesh, Vec3};
use mesher::{Ellipsoid, TriangleKind, TriangulatedSurface};
use shapes::{cylinder, grid_box, grid_ellipsoid};
use std::f64::consts::PI;

fn smooth(mesh: SurfaceMesh) -> TriangulatedSurface {
    TriangulatedSurface::new("surface", mesh, TriangleKind::Smooth)
        .unwrap_or_else(|e| panic!("{e}"))
}

fn faceted(mesh: SurfaceMesh) -> TriangulatedSurface {
    TriangulatedSurface::new("surface", mesh, TriangleKind::Faceted)
        .unwrap_or_else(|e| panic!("{e}"))
}

fn points(count: u32) -> impl Iterator<Item = Vec3> {
    (0..count).map(|k| {
        let k = f64::from(k);
        Vec3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k + 0.3).sin())
    })
}

/// Measured: 4.9e-3, 4.5e-4, 3.4e-5 with 24, 48 and 96 points around; flat triangles have 1.7e-2,
/// 4.3e-3, 1.1e-3.
#[test]
fn smooth_surfaces_follow_the_shape_on_which_their_vertices_are() {
    let exact = Ellipsoid {
        semi_axes: Vec3::new(2.0, 1.0, 1.0),
    };
    let mut last: f64 = 0.1;
    for n in [24, 48, 96] {
        let surface = smooth(grid_ellipsoid(exact.semi_axes, n));
        let mut worst = 0f64;
        for d in points(1000) {
            let x = exact.closest_point(2.0 * d);
            worst = worst.max(surface.signed_distance(x).abs());
        }
        // The third order at least.
        assert!(worst < last / 8.0, "{n}: {worst:.1e} {last:.1e}");
        last = worst;
        assert_relative_eq!(surface.volume(), exact.volume(), max_relative = worst);
        assert!(surface.centroid().norm() < 1e-12 && surface.is_convex());
        assert_relative_eq!(surface.inradius(), 1.0, epsilon = worst);
        // The smallest radius of curvature is 0.5, known within 15 per cent.
        assert!(
            (0.4..0.56).contains(&surface.reach()),
            "{}",
            surface.reach()
        );
    }
}

#[test]
fn distances_have_signs_and_closest_points() {
    let exact = Ellipsoid {
        semi_axes: Vec3::new(2.0, 1.0, 1.0),
    };
    let surface = smooth(grid_ellipsoid(exact.semi_axes, 48));
    for d in points(500) {
        for x in [0.3 * d, 1.5 * d, 9.0 * d] {
            let (own, true_one) = (surface.signed_distance(x), exact.signed_distance(x));
            assert!((own - true_one).abs() < 1e-3, "{x} {own} {true_one}");
            let foot = surface.closest_point(x);
            assert_relative_eq!((x - foot).norm(), own.abs(), epsilon = 1e-12);
            assert!(surface.signed_distance(foot).abs() < 1e-9);
        }
    }
}

/// At convex and concave edges and at corners the sign is that of the pseudo-normal.
#[test]
fn a_cube_has_exact_distances_inside_and_outside() {
    let cube = faceted(grid_box(Vec3::repeat(1.0), 3));
    for d in points(500) {
        for x in [0.7 * d, 1.3 * d, 3.0 * d] {
            let beyond = x.abs() - Vec3::repeat(1.0);
            let exact = beyond.map(|b| b.max(0.0)).norm() + beyond.max().min(0.0);
            assert_relative_eq!(cube.signed_distance(x), exact, epsilon = 1e-12);
        }
    }
    assert_relative_eq!(cube.volume(), 8.0, epsilon = 1e-12);
    assert_relative_eq!(cube.area(), 24.0, epsilon = 1e-12);
    let on_edge = cube.closest_on_sharp_edges(Vec3::new(2.0, 3.0, 0.1));
    assert!((on_edge.expect("it has edges") - Vec3::new(1.0, 1.0, 0.1)).norm() < 1e-12);
    assert_eq!(cube.farthest(Vec3::x()).x, 1.0);
    assert_relative_eq!(cube.largest_distance_from_axis(Vec3::z()), 2f64.sqrt());
}

/// The rim of the cylinder is sharp and round, its wall smooth, its ends flat.
#[test]
fn sharp_edges_are_kept_and_curved() {
    let surface = smooth(cylinder(1.0, 2.0, 24, 6));
    // A cubic edge of half the angle 7.5 degrees errs by 3/8 of its fourth power, 1.1e-4; the
    // polygon by 9e-3.
    for k in 0..48 {
        let (sin, cos) = (PI * f64::from(k) / 24.0).sin_cos();
        let x = Vec3::new(1.2 * cos, 1.2 * sin, 1.9);
        let rim = surface.closest_on_sharp_edges(x).expect("it has a rim");
        assert_relative_eq!(rim.z, 2.0, epsilon = 1e-12);
        assert_relative_eq!(rim.xy().norm(), 1.0, epsilon = 1.2e-4);
        assert_relative_eq!(
            surface.signed_distance(Vec3::new(cos, sin, 0.1)),
            0.0,
            epsilon = 1e-3
        );
        // On the flat ends nothing bulges.
        let on_end = surface.closest_point(Vec3::new(0.5 * cos, 0.5 * sin, 2.5));
        assert_relative_eq!(on_end.z, 2.0, epsilon = 1e-12);
    }
    assert_relative_eq!(surface.volume(), 4.0 * PI, max_relative = 1e-3);
}

#[test]
fn scale_and_origin_change_coordinates_only() {
    let own = smooth(grid_ellipsoid(Vec3::new(2.0, 1.0, 1.0), 24));
    let origin = Vec3::new(0.3, -0.2, 0.1);
    let moved = own.about(origin).scaled(10.0);
    assert_relative_eq!(moved.volume(), 1000.0 * own.volume(), max_relative = 1e-14);
    assert_relative_eq!(moved.reach(), 10.0 * own.reach(), max_relative = 1e-14);
    for x in points(100) {
        let there = 10.0 * (x - origin);
        assert_relative_eq!(
            moved.signed_distance(there),
            10.0 * own.signed_distance(x),
            epsilon = 1e-12
        );
    }
    assert!(moved.scaled(0.1).about(-origin) != moved && moved == moved.clone());
    let (centre, radius) = moved.bounding_ball();
    assert_eq!(centre, Vec3::zeros());
    assert!((10.0 * (2.0 + 0.3)..25.0).contains(&radius), "{radius}");
}
