//! Meshes cut at symmetry planes: as good as whole meshes, and of the same shape when unfolded.

use crate::{ball, curved, on_threads};
use mesh::{SYMMETRY_PLANE_TAGS, TetMesh, Vec3};
use mesher::{
    BentTube, BoxSurface, Capsule, Centreline, Container, CurvePoint, GenerateError,
    GenerateParams, MeshedBody, Sphere, TubeProfile,
};

fn sphere(x: f64, y: f64, radius: f64) -> Sphere {
    Sphere::new(Vec3::new(x, y, 0.0), radius)
}

fn mesh(
    spheres: &[Sphere],
    size: f64,
    container: &Container,
    symmetry_planes: [bool; 3],
) -> Result<TetMesh, GenerateError> {
    let bodies: Vec<MeshedBody<'_>> = spheres
        .iter()
        .zip(["a", "b", "c"])
        .map(|(surface, name)| MeshedBody {
            name,
            surface,
            size: size * surface.radius,
        })
        .collect();
    let mut params = GenerateParams::default();
    params.symmetry_planes = symmetry_planes;
    Ok(curved(&bodies, container, &params)?.1)
}

/// Cases: one half, quarter and eighth; distant, close and unequal spheres; ball and box.
#[test]
fn cut_meshes_are_as_good_as_whole_meshes_and_unfold_to_them() {
    let apart = [
        sphere(-4.0, 0.0, 1.0),
        sphere(0.0, 0.0, 1.0),
        sphere(5.0, 0.0, 1.0),
    ];
    let close = [
        sphere(-2.2, 0.0, 1.0),
        sphere(0.0, 0.0, 1.0),
        sphere(2.0, 0.0, 0.7),
    ];
    let triangle = [
        sphere(-2.0, 0.0, 1.0),
        sphere(2.0, 0.0, 1.0),
        sphere(0.0, 3.0, 1.0),
    ];
    let alone = [sphere(0.0, 0.0, 1.0)];
    let sides = Container::Box(BoxSurface {
        min: Vec3::new(-8.0, -6.0, -5.0),
        max: Vec3::new(9.0, 6.0, 5.0),
    });
    let z = [false, false, true];
    let yz = [false, true, true];
    let cases: [(&str, &[Sphere], Container, [bool; 3]); 8] = [
        ("apart", &apart, ball(20.0), z),
        ("apart", &apart, ball(20.0), yz),
        ("close", &close, ball(20.0), yz),
        ("triangle", &triangle, ball(20.0), z),
        ("alone", &alone, ball(10.0), [true; 3]),
        ("alone", &alone, ball(1.2), [true; 3]),
        ("in a box", &apart, sides.clone(), z),
        ("in a box", &apart, sides, yz),
    ];
    for (name, spheres, container, symmetry_planes) in cases {
        let case = format!("{name} {symmetry_planes:?}");
        let part = mesh(spheres, 0.4, &container, symmetry_planes)
            .unwrap_or_else(|e| panic!("{case}: {e}"));
        let full =
            mesh(spheres, 0.4, &container, [false; 3]).unwrap_or_else(|e| panic!("{case}: {e}"));
        let whole = part
            .unfolded()
            .unwrap_or_else(|e| panic!("{case}: {e}"))
            .mesh;
        let n_planes = symmetry_planes.iter().filter(|&&m| m).count();
        let (q, f) = (part.quality(), full.quality());
        println!(
            "{case}: {} vertices, {} unfolded, {} in a whole mesh; cut and whole: mean quality {:.3} and \
             {:.3}, smallest {:.3} and {:.3}, Jacobian {:.3} and {:.3}",
            part.n_vertices(),
            whole.n_vertices(),
            full.n_vertices(),
            q.mean_quality,
            f.mean_quality,
            q.min_quality,
            f.min_quality,
            q.min_jacobian,
            f.min_jacobian,
        );
        assert_eq!(part.symmetry_planes(), symmetry_planes, "{case}");
        for axis in (0..3).filter(|&axis| symmetry_planes[axis]) {
            let tag = part.tag(SYMMETRY_PLANE_TAGS[axis]).expect("a plane");
            assert!(
                part.nodes_on(tag)
                    .iter()
                    .all(|&n| part.points()[n as usize][axis] == 0.0)
            );
        }
        // Curved boundaries are of fourth order, so the two volumes agree to a small multiple of
        // that.
        assert!(
            (whole.volume() / full.volume() - 1.0).abs() < 2e-3,
            "{case}"
        );
        assert!(((1 << n_planes) as f64 * part.volume() / whole.volume() - 1.0).abs() < 1e-12);
        assert!(q.mean_quality > f.mean_quality - 0.04, "{case}");
        assert!(q.min_quality > 0.25 && q.min_jacobian > 0.2, "{case}");
        // The number of vertices is similar; the planes need some of their own.
        let ratio = whole.n_vertices() as f64 / full.n_vertices() as f64;
        assert!((0.75..1.4).contains(&ratio), "{case}: {ratio}");
    }
}

/// A long body beside a plane may be closer to it than half its length.
#[test]
fn a_capsule_along_a_plane_is_meshed_beside_it() {
    let refusal = |height: f64| {
        let capsule = Capsule::new(Vec3::new(0.0, 0.0, height), 0.5, 1.0);
        let body = MeshedBody::new("a", &capsule, 0.25);
        let mut params = GenerateParams::default();
        params.symmetry_planes = [false, false, true];
        let (_, mesh) = curved(&[body], &ball(10.0), &params)?;
        assert!(mesh.quality().min_jacobian > 0.2);
        Ok::<(), GenerateError>(())
    };
    refusal(0.9).unwrap();
    let refused = refusal(0.45);
    assert!(matches!(refused, Err(GenerateError::NotSymmetric { part, .. }) if part == "a"));
}

/// An arc of a circle in the plane z = 0, about the origin.
struct Bow {
    length: f64,
    radius: f64,
}

impl Centreline for Bow {
    fn length(&self) -> f64 {
        self.length
    }

    fn parts(&self) -> f64 {
        self.length / self.radius
    }

    fn at(&self, arc: f64) -> CurvePoint {
        let (sin, cos) = ((arc - 0.5 * self.length) / self.radius).sin_cos();
        let normal = Vec3::new(-sin, cos, 0.0);
        CurvePoint {
            point: self.radius * Vec3::new(sin, 1.0 - cos, 0.0),
            axes: [Vec3::new(cos, sin, 0.0), normal, Vec3::z()],
            curvature: normal / self.radius,
        }
    }
}

/// Bent tubes whose heads are joined by a concave fillet, where a tet between four vertices of the
/// surface had two faces that the curved surface joins smoothly: it had no volume.
#[test]
fn bug_tets_in_concave_fillets_were_inverted() {
    for (radius, size) in [
        (4.0, 0.175),
        (6.0, 0.175),
        (20.0, 0.175),
        (4.0, 0.22),
        (9.0, 0.22),
    ] {
        let profile = TubeProfile::new(8.0, [0.5, 0.5], Some(1.0));
        let tube = BentTube::new(
            Bow {
                length: 8.0,
                radius,
            },
            profile,
        );
        let volumes = [false, true].map(|half| {
            let mut params = GenerateParams::default();
            params.symmetry_planes = [false, false, half];
            let body = MeshedBody::new("tube", &tube, size);
            let (_, mesh) = curved(&[body], &ball(40.0), &params).unwrap();
            assert!(mesh.quality().min_jacobian > 0.0);
            if half {
                2.0 * mesh.volume()
            } else {
                mesh.volume()
            }
        });
        // Curved boundaries of both meshes are of fourth order, the wall is the coarser one.
        assert!(
            (volumes[0] / volumes[1] - 1.0).abs() < 2e-3,
            "{radius} {size}"
        );
    }
}

#[test]
fn scenes_without_the_symmetry_are_refused() {
    let off = [sphere(0.0, 0.1, 1.0)];
    let refused = mesh(&off, 0.5, &ball(10.0), [false, true, false]);
    assert!(
        matches!(refused, Err(GenerateError::NotSymmetric { part, plane: "mirror-y" }) if part == "a")
    );
    let shifted = Container::Ball(sphere(0.0, 0.2, 10.0));
    let refused = mesh(
        &[sphere(0.0, 0.0, 1.0)],
        0.5,
        &shifted,
        [false, true, false],
    );
    assert!(
        matches!(refused, Err(GenerateError::NotSymmetric { part, .. }) if part == Container::TAG)
    );
}

#[test]
fn cut_meshes_are_the_same_for_any_number_of_threads() {
    let spheres = [sphere(-3.0, 0.0, 1.0), sphere(3.0, 0.0, 1.0)];
    let on = |threads: usize| {
        let cut = || mesh(&spheres, 0.6, &ball(12.0), [false, true, true]);
        on_threads(threads, cut).expect("a mesh")
    };
    assert_eq!(on(1), on(3));
}

/// A body need not be cut by a plane: the plane may be a wall.
#[test]
fn bodies_may_lie_beside_a_plane() {
    let container = ball(10.0);
    for (spheres, planes) in [
        (vec![sphere3(0.0, 0.0, 1.5)], [true; 3]),
        (vec![sphere3(0.0, 0.0, 1.2)], [false, true, true]),
        (
            vec![sphere3(0.4, 0.1, 3.0), sphere3(2.9, 0.6, 2.0)],
            [false, false, true],
        ),
    ] {
        let part = mesh(&spheres, 0.5, &container, planes).unwrap();
        let share =
            |axes: &[bool]| 0.5_f64.powi(axes.iter().filter(|&&plane| plane).count() as i32);
        let ball_volume = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        let of_bodies = spheres.len() as f64 * share(&planes[..2]) * ball_volume(1.0);
        let exact = share(&planes) * ball_volume(10.0) - of_bodies;
        // Curved elements of these sizes approximate volumes to 1e-3 and better.
        let volume = part.volume();
        assert!(
            (volume / exact - 1.0).abs() < 2e-3,
            "{planes:?}: {volume} {exact}"
        );
        assert!(part.quality().min_quality > 0.2, "{planes:?}");
    }
}

#[test]
fn a_body_that_touches_a_plane_beside_it_is_refused() {
    for height in [0.999, 1.0] {
        let error = mesh(
            &[sphere3(0.0, 0.0, height)],
            0.5,
            &ball(10.0),
            [false, false, true],
        );
        assert!(
            matches!(error, Err(GenerateError::NotSymmetric { .. })),
            "{error:?}"
        );
    }
}

fn sphere3(x: f64, y: f64, z: f64) -> Sphere {
    Sphere::new(Vec3::new(x, y, z), 1.0)
}
