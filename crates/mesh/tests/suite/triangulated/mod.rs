//! Surfaces of triangles: closest points, meshes around and inside them, and refused files.

mod shapes;

use mesh::*;
use shapes::*;
use std::time::Instant;

#[test]
fn experiment() {
    let axes = Vec3::new(2.0, 1.0, 1.0);
    let exact = Ellipsoid { semi_axes: axes };
    for (label, mesh) in [
        ("grid 24", grid_ellipsoid(axes, 24)),
        ("grid 48", grid_ellipsoid(axes, 48)),
        ("grid 96", grid_ellipsoid(axes, 96)),
        ("faces .4", meshed(&exact, 0.4)),
        ("faces .2", meshed(&exact, 0.2)),
        ("faces .1", meshed(&exact, 0.1)),
    ] {
        let start = Instant::now();
        let n = mesh.triangles.len();
        let surface = TriangulatedSurface::new("e", mesh, TriangleKind::Smooth).unwrap();
        let built = start.elapsed().as_secs_f64();
        let (mut worst, mut sum, mut count) = (0f64, 0f64, 0);
        for k in 0..4000 {
            let k = f64::from(k);
            let d = Vec3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k + 0.3).sin()).normalize();
            let x = exact.closest_point(d.component_mul(&axes));
            let e = surface.signed_distance(x);
            worst = worst.max(e.abs());
            sum += e * e;
            count += 1;
            for h in [-0.3, 0.4, 3.0] {
                let y = x * (1.0 + h);
                let (a, b) = (surface.signed_distance(y), exact.signed_distance(y));
                assert!((a - b).abs() < 0.1 && a.signum() == b.signum(), "{a} {b}");
            }
        }
        println!(
            "{label} n {n} built {built:.3} worst {worst:.2e} rms {:.2e} vol {:.2e} area {} inradius {} reach {} (.5) convex {} centroid {:?} samples",
            (sum / f64::from(count)).sqrt(),
            surface.volume() / exact.volume() - 1.0,
            surface.area(),
            surface.inradius(),
            surface.reach(),
            surface.is_convex(),
            surface.centroid(),
        );
        let start = Instant::now();
        let mut s = 0.0;
        for k in 0..100000 {
            let k = f64::from(k);
            let d = Vec3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k + 0.3).sin()) * 3.0;
            s += surface.signed_distance(d);
        }
        println!("  query {:.2} us {s}", start.elapsed().as_secs_f64() * 10.0);
        let start = Instant::now();
        for k in 0..100000 {
            let k = f64::from(k);
            let d = Vec3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k + 0.3).sin()) * 3.0;
            s += surface.curvature_size(d, 0.7, 0.3);
        }
        println!(
            "  curvature size {:.2} us {s}",
            start.elapsed().as_secs_f64() * 10.0
        );
        for size in [0.4, 0.2] {
            let container = Container::Ball(Sphere {
                centre: Vec3::zeros(),
                radius: 8.0,
            });
            let start = Instant::now();
            let result = generate(
                &[MeshedBody {
                    name: "b",
                    surface: &surface,
                    size,
                }],
                &container,
                &GenerateParams::default(),
            );
            let t = start.elapsed().as_secs_f64();
            let start = Instant::now();
            let tets = generate(
                &[MeshedBody {
                    name: "b",
                    surface: &exact,
                    size,
                }],
                &container,
                &GenerateParams::default(),
            )
            .unwrap()
            .mesh;
            let t2 = start.elapsed().as_secs_f64();
            match result {
                Ok(m) => {
                    let mesh = TetMesh::curved(
                        m.mesh.clone(),
                        &[("b", &surface), (Container::TAG, container.surface())],
                    );
                    println!(
                        "  size {size}: {} faces {} tets ({} of formula) {t:.2} s ({t2:.2}) {:?}",
                        m.mesh.faces.iter().filter(|f| f.1 == 0).count(),
                        m.mesh.tets.len(),
                        tets.tets.len(),
                        mesh.map(|m| m.quality())
                    );
                }
                Err(e) => println!("  size {size}: {e}"),
            }
        }
    }
}

#[test]
fn experiment_sharp() {
    let torus = Torus {
        radius: 2.0,
        tube: 0.7,
    };
    for (label, mesh, kind, volume) in [
        (
            "cube 1",
            grid_box(Vec3::repeat(1.0), 1),
            TriangleKind::Smooth,
            8.0,
        ),
        (
            "cube 6",
            grid_box(Vec3::repeat(1.0), 6),
            TriangleKind::Faceted,
            8.0,
        ),
        (
            "plate",
            grid_box(Vec3::new(1.0, 1.0, 0.2), 6),
            TriangleKind::Smooth,
            1.6,
        ),
        (
            "cylinder 16",
            cylinder(1.0, 2.0, 16, 4),
            TriangleKind::Smooth,
            4.0 * std::f64::consts::PI,
        ),
        (
            "cylinder 32",
            cylinder(1.0, 2.0, 32, 10),
            TriangleKind::Smooth,
            4.0 * std::f64::consts::PI,
        ),
        (
            "cylinder 32 f",
            cylinder(1.0, 2.0, 32, 10),
            TriangleKind::Faceted,
            4.0 * std::f64::consts::PI,
        ),
        (
            "torus",
            meshed(&torus, 0.3),
            TriangleKind::Smooth,
            torus.volume(),
        ),
    ] {
        let start = Instant::now();
        let n = mesh.triangles.len();
        let surface = match TriangulatedSurface::new("e", mesh, kind) {
            Ok(s) => s,
            Err(e) => {
                println!("{label} {e}");
                continue;
            }
        };
        let built = start.elapsed().as_secs_f64();
        println!(
            "{label} n {n} built {built:.3} vol {:.2e} inradius {} reach {} convex {}",
            surface.volume() / volume - 1.0,
            surface.inradius(),
            surface.reach(),
            surface.is_convex(),
        );
        for inside in [true] {
            for size in [0.4, 0.2] {
                let start = Instant::now();
                let sphere = Sphere {
                    centre: Vec3::new(0.1, 0.05, 0.0),
                    radius: 0.2,
                };
                let ball = Container::Ball(Sphere {
                    centre: Vec3::zeros(),
                    radius: 8.0,
                });
                let container = if inside {
                    Container::Surface(surface.clone())
                } else {
                    ball
                };
                let body: &dyn Surface = if inside { &sphere } else { &surface };
                if label == "torus" && inside || label == "plate" && inside {
                    continue;
                }
                let result = generate(
                    &[MeshedBody {
                        name: "b",
                        surface: body,
                        size: if inside { 0.5 * size } else { size },
                    }],
                    &container,
                    &GenerateParams::default(),
                );
                let t = start.elapsed().as_secs_f64();
                match result {
                    Ok(m) => {
                        let tag = if inside { 1 } else { 0 };
                        let mesh = TetMesh::curved(
                            m.mesh.clone(),
                            &[("b", body), (Container::TAG, container.surface())],
                        );
                        let total = if inside {
                            volume - sphere.volume()
                        } else {
                            container.surface().volume() - volume
                        };
                        println!(
                            "  inside {inside} size {size}: {} faces {} tets {t:.2} s {:?} {:?}",
                            m.mesh.faces.iter().filter(|f| f.1 == tag).count(),
                            m.mesh.tets.len(),
                            mesh.as_ref().map(|m| m.quality()),
                            mesh.as_ref().map(|m| (m.volume() - total) / volume)
                        );
                    }
                    Err(e) => println!("  inside {inside} size {size}: {e}"),
                }
            }
        }
    }
}
