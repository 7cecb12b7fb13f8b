//! Bodies and domains whose surfaces are in files: the same answers as for the formulas.

use std::f64::consts::PI;
use std::path::Path;

use mesh::{SurfaceMesh, Vec3};
use models::{Configuration, FemModel, Hydrodynamics, InstantaneousSolution};
use scene::Scene;

use crate::scenes::solve_at_start;

/// An ellipsoid by circles of latitude with `n` points each, shifted by `by`.
fn ellipsoid(semi_axes: [f64; 3], n: usize, by: Vec3) -> SurfaceMesh {
    let mut mesh = SurfaceMesh::default();
    let rows = n / 2;
    let at = |row: usize, k: usize| (1 + (row - 1) * n + k % n) as u32;
    mesh.points.push(-Vec3::z());
    for row in 1..rows {
        let (sin, cos) = (PI * row as f64 / rows as f64).sin_cos();
        let around = (0..n).map(|k| 2.0 * PI * k as f64 / n as f64);
        let circle = around.map(|a| Vec3::new(sin * a.cos(), sin * a.sin(), -cos));
        mesh.points.extend(circle);
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
        *p = p.component_mul(&Vec3::from(semi_axes)) + by;
    }
    mesh
}

fn write_stl(folder: &Path, mesh: &SurfaceMesh) -> String {
    let file = folder.join("part.stl");
    std::fs::write(&file, mesh.to_stl()).unwrap();
    format!("shape = \"surface\", file = {file:?}")
}

fn answer(scene: &Scene) -> InstantaneousSolution {
    solve_at_start(&mut FemModel::new(scene).unwrap(), &[])
}

const LOAD: &str = "force = [10, 4, 0], torque = [5, 0, 20]";

/// A turned ellipsoid 2:1:1 as formula, as STL file and as part of a mesh file, in a ball.
#[test]
fn an_ellipsoid_as_formula_as_surface_and_as_mesh_part() {
    let folder = tempfile::tempdir().unwrap();
    let part = ellipsoid([2.0, 1.0, 1.0], 64, Vec3::new(0.5, 3.0, -1.0));
    let of_stl = write_stl(folder.path(), &part);
    let scene = |domain: &str, body: &str| {
        let text = format!(
            "domain = {domain}\nmodel.kind = \"fem\"\nfem.size_factor = 1.5\n\
             bodies = [{{ name = \"body\", {body}, {LOAD} }}]"
        );
        Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
    };
    let placed = "position = [1, 0.5, 0], orientation = [0.3, 0.2, 0.5]";
    let ball = "{ kind = \"ball\", radius = 8 }";
    let formula = scene(
        ball,
        &format!("shape = \"ellipsoid\", semi_axes = [2, 1, 1], {placed}"),
    );
    let surface = scene(ball, &format!("{of_stl}, {placed}"));
    let mut model = FemModel::new(&formula).unwrap();
    let expected = solve_at_start(&mut model, &[]);

    let file = folder.path().join("ball.msh");
    let state = formula.initial_state();
    let configuration = Configuration {
        state: &state,
        shape: &[],
    };
    let mesh = model.mesh(configuration).unwrap().unwrap();
    mesh.write(&file).unwrap();
    let domain = format!("{{ kind = \"mesh\", file = {file:?}, walls = [\"outer\"] }}");
    let part = scene(&domain, "shape = \"file\", surface = \"body\"");
    // The centre is that of the volume: curved facets follow the ellipsoid within 1e-3.
    let centre = part.bodies()[0].position;
    assert!(
        (centre - Vec3::new(1.0, 0.5, 0.0)).norm() < 1e-3,
        "{centre}"
    );

    for (label, scene) in [("surface", &surface), ("mesh part", &part)] {
        let found = answer(scene);
        let [a, b] = [&found, &expected].map(|solution| &solution.bodies[0]);
        let bars = found.error_estimate.total() + expected.error_estimate.total();
        // The file follows the ellipsoid within 2e-4, which no bar knows.
        let allowed = bars + 2e-4 * b.velocity.norm();
        let difference = (a.velocity - b.velocity).norm();
        assert!(
            difference <= allowed,
            "{label} {difference:.1e} {allowed:.1e}"
        );
        let spin = (a.angular_velocity - b.angular_velocity).norm();
        assert!(
            spin <= 2e-3 * b.angular_velocity.norm(),
            "{label} {spin:.1e}"
        );
        assert!(found.error_estimate.total() < 1e-2 * b.velocity.norm());
    }
    // What was read is written, and read again.
    let written = Scene::parse(&part.to_toml().unwrap()).unwrap();
    assert_eq!(written.bodies(), part.bodies());
    assert!(matches!(&written.bodies()[0].shape, shape if shape.is_mesh_part()));
}

/// The drag of an ellipsoid 2:1:1 along its axis, in a file in other units of length: 1.2039409898
/// times that of the sphere of its equator (Oberbeck 1876).
#[test]
fn the_drag_of_a_surface_in_unbounded_fluid() {
    let folder = tempfile::tempdir().unwrap();
    let part = ellipsoid([2000.0, 1000.0, 1000.0], 64, Vec3::zeros());
    let scene = Scene::parse(&format!(
        "model.kind = \"fem\"\nbodies = [{{ name = \"body\", {}, scale = 1e-3, \
         position = [0, 0, 0], force = [{}, 0, 0] }}]",
        write_stl(folder.path(), &part),
        6.0 * PI
    ))
    .unwrap();
    let found = answer(&scene);
    let error = found.bodies[0].velocity.x * 1.2039409898 - 1.0;
    let bar = found.error_estimate.total() * 1.2039409898;
    assert!(
        error.abs() <= bar + 2e-4 && bar < 1e-3,
        "{error:.1e} {bar:.1e}"
    );
}

/// A sphere in a ball given by a file, and by its radius.
#[test]
fn a_domain_from_a_file_is_that_of_the_formula() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.stl");
    let ball = ellipsoid([4.0; 3], 48, Vec3::zeros());
    std::fs::write(&file, ball.to_stl()).unwrap();
    let scene = |domain: &str| {
        Scene::parse(&format!(
            "domain = {domain}\nmodel.kind = \"fem\"\nfem.symmetry = \"off\"\n\
             bodies = [{{ name = \"body\", radius = 1, position = [1, 0.5, 0], {LOAD} }}]"
        ))
        .unwrap()
    };
    let [found, expected] = [
        answer(&scene(&format!(
            "{{ kind = \"surface\", file = {file:?} }}"
        ))),
        answer(&scene("{ kind = \"ball\", radius = 4 }")),
    ];
    let difference = (found.bodies[0].velocity - expected.bodies[0].velocity).norm();
    let bars = found.error_estimate.total() + expected.error_estimate.total();
    let speed = expected.bodies[0].velocity.norm();
    assert!(
        difference <= bars + 2e-4 * speed,
        "{difference:.1e} {bars:.1e}"
    );
    assert!(bars < 1e-2 * speed, "{bars:.1e}");
}

/// A channel, which is not convex: a body beside its bend is outside.
#[test]
fn bodies_outside_of_a_bent_channel_are_refused() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/bent-channel.stl");
    let scene = |x: f64, y: f64, radius: f64| {
        Scene::parse(&format!(
            "domain = {{ kind = \"surface\", file = {file:?} }}\n\
             bodies = [{{ name = \"body\", radius = {radius}, position = [{x}, {y}, 0] }}]"
        ))
    };
    assert!(scene(0.0, 0.0, 3.9).is_ok());
    // The centre of the bend is 12 away from the middle of the channel, whose radius is 4.
    assert!(scene(8.5, 3.5, 1.0).is_ok());
    for (x, y, radius) in [
        (0.0, 0.0, 4.1),
        (0.0, 12.0, 1.0),
        (2.0, 10.0, 1.0),
        (8.5, 3.5, 5.0),
        (-15.0, 0.0, 0.5),
    ] {
        let error = scene(x, y, radius).unwrap_err().to_string();
        assert!(
            error.contains("outside the domain or touches its wall"),
            "{error}"
        );
    }
}
