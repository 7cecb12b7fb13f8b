//! Bodies that are not spheres: their surfaces are recovered, closed and of the right topology.

use super::{assert_good, checked};
use crate::{ball, euler_characteristic};
use mesh::{Surface, Vec3, check_surface};
use mesher::{
    BoxSurface, Capsule, Disk, Ellipsoid, GenerateError, GenerateParams, Helix, MeshedBody, Placed,
    Sphere, Torus, TriangleKind, TriangulatedSurface, generate,
};
use nalgebra::{Isometry3, Vector3};
use proptest::prelude::*;

/// A general position, so that no symmetry of the shape is one of the coordinates.
fn placed<S: Surface>(shape: S) -> Placed<S> {
    Placed {
        shape,
        pose: Isometry3::new(Vector3::new(0.3, -0.2, 0.5), Vector3::new(0.4, -0.7, 0.3)),
    }
}

fn capsule(half_length: f64) -> Capsule {
    Capsule::new(Vec3::zeros(), 1.0, half_length)
}

fn ellipsoid(semi_axes: [f64; 3]) -> Ellipsoid {
    Ellipsoid {
        semi_axes: semi_axes.into(),
    }
}

/// Meshes a shape in a ball, and checks the mesh, its quality and the topology of the surface.
fn check(label: &str, shape: &dyn Surface, size: f64, euler: i64) {
    let body = MeshedBody::new("body", shape, size);
    let (_, radius) = shape.bounding_ball();
    let (mesh, quality) = checked(&[body], &ball(4.0 * radius));
    assert_eq!(euler_characteristic(&mesh, 0), euler, "{label}");
    assert_good(&format!("{label}, size {size}"), &quality);
}

#[test]
fn ellipsoids_of_any_proportions() {
    for (axes, size) in [
        ([2.0, 1.0, 1.0], 0.7),
        ([10.0, 1.0, 1.0], 0.7),
        ([0.5, 0.4, 4.0], 0.4),
        ([1.0, 0.5, 1.0], 0.4),
        ([0.25, 1.0, 1.0], 0.4),
        ([3.0, 1.0, 2.0], 0.7),
    ] {
        check(
            &format!("ellipsoid {axes:?}"),
            &placed(ellipsoid(axes)),
            size,
            2,
        );
    }
}

#[test]
fn capsules_and_disks() {
    for (half_length, size) in [(1.0, 0.7), (2.0, 0.4), (9.0, 0.4)] {
        check(
            &format!("capsule {half_length}"),
            &placed(capsule(half_length)),
            size,
            2,
        );
    }
    for (half_thickness, size) in [(0.5, 0.4), (0.2, 0.1), (0.1, 0.4)] {
        let disk = Disk {
            radius: 1.0,
            half_thickness,
        };
        check(&format!("disk {half_thickness}"), &placed(disk), size, 2);
    }
}

#[test]
fn tori_have_the_euler_characteristic_zero() {
    for (tube, size) in [(0.6, 0.4), (0.4, 0.28), (0.4, 0.16), (0.2, 0.14)] {
        let torus = Torus { radius: 1.0, tube };
        check(&format!("torus {tube}"), &placed(torus), size, 0);
    }
}

#[test]
fn helices() {
    for (pitch, turns, tube) in [(2.0, 2.0, 0.3), (-4.0, 1.0, 0.2), (3.0, 0.3, 0.2)] {
        let helix = Helix::new(1.0, pitch, turns, tube);
        check(
            &format!("helix {pitch} {turns}"),
            &placed(helix),
            0.7 * tube,
            2,
        );
    }
}

/// A sphere in the hole of a torus: shapes that are not convex have gaps anywhere.
#[test]
fn a_sphere_in_the_hole_of_a_torus() {
    let torus = placed(Torus {
        radius: 2.0,
        tube: 0.5,
    });
    for (radius, fits) in [(1.2, true), (1.6, false)] {
        let sphere = Sphere::new(torus.centre(), radius);
        let bodies = [
            ("ring", &torus as &dyn Surface, 0.3),
            ("ball", &sphere, 0.5),
        ];
        let bodies = bodies.map(|(name, surface, size)| MeshedBody {
            name,
            surface,
            size,
        });
        if fits {
            let (mesh, quality) = checked(&bodies, &ball(20.0));
            assert_good("sphere in torus", &quality);
            assert_eq!(euler_characteristic(&mesh, 0), 0);
        } else {
            let result = generate(&bodies, &ball(20.0), &GenerateParams::default());
            assert_refused!(result, GenerateError::BodiesTouch { .. });
        }
    }
}

/// A helix that touches itself has no reach.
#[test]
fn a_helix_that_touches_itself_is_refused() {
    for (pitch, turns, tube) in [(0.5, 2.0, 0.3), (4.0, 2.0, 1.7)] {
        let helix = Helix::new(1.0, pitch, turns, tube);
        let body = MeshedBody::new("body", &helix, 0.1);
        let result = generate(&[body], &ball(20.0), &GenerateParams::default());
        assert_refused!(result, GenerateError::BadParameter { .. });
    }
}

fn shapes() -> [(&'static str, Box<dyn Surface>); 5] {
    let disk = Disk {
        radius: 1.0,
        half_thickness: 0.2,
    };
    let torus = Torus {
        radius: 1.0,
        tube: 0.3,
    };
    [
        ("ellipsoid", Box::new(placed(ellipsoid([1.0, 0.3, 0.7])))),
        ("capsule", Box::new(placed(capsule(0.8)))),
        ("disk", Box::new(placed(disk))),
        ("torus", Box::new(placed(torus))),
        ("helix", Box::new(placed(Helix::new(0.7, 0.9, 1.7, 0.2)))),
    ]
}

/// Midpoint rule on a grid of 60 points per direction: 1 % for the thinnest shape.
#[test]
fn volumes_are_those_of_the_points_inside() {
    const N: i32 = 60;
    for (label, shape) in shapes() {
        let (centre, radius) = shape.bounding_ball();
        let width = 2.0 * radius / f64::from(N);
        let at = |k: i32| radius * (f64::from(2 * k + 1) / f64::from(N) - 1.0);
        let mut count = 0;
        for (i, j) in (0..N).flat_map(|i| (0..N).map(move |j| (i, j))) {
            let inside =
                |k: &i32| shape.signed_distance(centre + Vec3::new(at(i), at(j), at(*k))) < 0.0;
            count += (0..N).filter(inside).count();
        }
        let volume = count as f64 * width.powi(3);
        assert!(
            (volume / shape.volume() - 1.0).abs() < 0.01,
            "{label}: {volume}"
        );
    }
}

proptest! {
    /// Distances belong to closest points, have slope one at most, and do not exceed those of
    /// vertices of the triangulation.
    #[test]
    fn distances_and_closest_points_agree(
        a in prop::array::uniform3(-2.0..2.0f64), b in prop::array::uniform3(-0.1..0.1f64),
    ) {
        for (label, shape) in shapes() {
            let (x, y) = (Vec3::from(a), Vec3::from(a) + Vec3::from(b));
            let (d, foot) = (shape.signed_distance(x), shape.closest_point(x));
            prop_assert!((d.abs() - (x - foot).norm()).abs() < 1e-12, "{label}");
            prop_assert!(shape.signed_distance(foot).abs() < 1e-12, "{label}");
            prop_assert!((shape.signed_distance(y) - d).abs() <= (x - y).norm() + 1e-12, "{label}");
            let (centre, radius) = shape.bounding_ball();
            prop_assert!(d >= (x - centre).norm() - radius - 1e-12, "{label}");
            for p in shape.triangulation().into_iter().flat_map(|mesh| mesh.points) {
                prop_assert!(shape.signed_distance(p).abs() < 1e-12, "{label}");
                prop_assert!(d.abs() <= (x - p).norm() + 1e-12, "{label}");
            }
        }
    }
}

/// Distances, closest points and normals of all shapes agree.
#[test]
fn all_shapes_pass_the_check_of_surfaces() {
    let helix = Helix::new(1.0, 3.0, 1.5, 0.3);
    let cylinder = crate::triangulated::shapes::cylinder(1.0, 1.5, 24, 8);
    let sharp = TriangulatedSurface::new("cylinder", cylinder, TriangleKind::Faceted);
    let shapes: [(&str, &dyn Surface); 8] = [
        (
            "sphere",
            &placed(Sphere::new(Vec3::new(3.0, 1.0, -2.0), 0.7)),
        ),
        ("capsule", &placed(capsule(2.0))),
        ("ellipsoid", &placed(ellipsoid([1.0, 0.7, 0.3]))),
        (
            "disk",
            &placed(Disk {
                radius: 1.0,
                half_thickness: 0.2,
            }),
        ),
        (
            "torus",
            &placed(Torus {
                radius: 1.0,
                tube: 0.4,
            }),
        ),
        ("helix", &placed(helix)),
        (
            "box",
            &BoxSurface {
                min: Vec3::zeros(),
                max: Vec3::new(1.0, 2.0, 3.0),
            },
        ),
        ("cylinder of triangles", &sharp.unwrap()),
    ];
    for (label, shape) in shapes {
        check_surface(shape).unwrap_or_else(|error| panic!("{label}: {error}"));
    }
}
