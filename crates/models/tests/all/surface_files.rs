//! Bodies and domains whose surfaces are in files: the same answers as for the formulas.

use std::f64::consts::PI;
use std::path::Path;

use mesh::{SurfaceMesh, Vec3};
use models::{FemModel, Hydrodynamics, InstantaneousSolution};
use scene::Scene;
use testkit::exact::BODIES;
use testkit::{SceneText, within};

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

/// A body by finite elements under a force and a torque, with further keys.
fn loaded(keys: &str) -> SceneText {
    let load = "force = [10, 4, 0], torque = [5, 0, 20]";
    let body = format!("bodies = [{{ name = \"body\", {keys}, {load} }}]");
    SceneText::file(&body).with("model.kind", "fem")
}

/// The same velocity up to both error bars, and 2e-4 of the file, which no bar
/// knows.
fn assert_same(what: &str, found: &InstantaneousSolution, expected: &InstantaneousSolution) -> f64 {
    let [a, b] = [found, expected].map(|solution| solution.bodies[0].velocity);
    let bars = found.error_estimate.total() + expected.error_estimate.total();
    let why = format!("both error bars, and 2e-4 of the file: {what}");
    within((a - b).norm(), bars + 2e-4 * b.norm(), why);
    bars
}

/// A turned ellipsoid 2:1:1 as formula, as STL file and as part of a mesh file, in a ball.
#[test]
fn an_ellipsoid_as_formula_as_surface_and_as_mesh_part() {
    let folder = tempfile::tempdir().unwrap();
    let part = ellipsoid([2.0, 1.0, 1.0], 64, Vec3::new(0.5, 3.0, -1.0));
    let of_stl = write_stl(folder.path(), &part);
    let placed = "position = [1, 0.5, 0], orientation = [0.3, 0.2, 0.5]";
    let scene = |keys: &str| {
        loaded(&format!("{keys}, {placed}"))
            .ball(8.0)
            .with("fem.size_factor", 1.5)
            .scene()
    };
    let formula = scene("shape = \"ellipsoid\", semi_axes = [2, 1, 1]");
    let surface = scene(&of_stl);
    let mut model = FemModel::new(&formula).unwrap();
    let expected = solve_at_start(&mut model, &[]);

    let file = folder.path().join("ball.msh");
    let state = formula.initial_state();
    let configuration = testkit::at(&state, &[]);
    let mesh = model.mesh(configuration).unwrap().unwrap();
    mesh.write(&file).unwrap();
    let domain = format!("{{ kind = \"mesh\", file = {file:?}, walls = [\"outer\"] }}");
    let part = loaded("shape = \"file\", surface = \"body\"").with("domain", domain);
    let part = part.with("fem.size_factor", 1.5).scene();
    // The centre is that of the volume: curved facets follow the ellipsoid within 1e-3.
    let centre = part.bodies()[0].position;
    within(
        (centre - Vec3::new(1.0, 0.5, 0.0)).norm(),
        1e-3,
        "curved facets",
    );

    for (label, scene) in [("surface", &surface), ("mesh part", &part)] {
        let found = answer(scene);
        let [a, b] = [&found, &expected].map(|solution| &solution.bodies[0]);
        assert_same(label, &found, &expected);
        let spin = (a.angular_velocity - b.angular_velocity).norm();
        let why = format!("as velocities, which have bars of 1e-2: {label}");
        within(spin, 2e-3 * b.angular_velocity.norm(), why);
        within(
            found.error_estimate.total(),
            1e-2 * b.velocity.norm(),
            "the bar says something",
        );
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
    let keys = format!("{}, scale = 1e-3", write_stl(folder.path(), &part));
    let text = SceneText::new()
        .shape("body", &keys, [0; 3])
        .with("model.kind", "fem");
    let force = format!("[{}, 0, 0]", 6.0 * PI);
    let found = answer(&text.with("bodies.body.force", force).scene());
    let drag = BODIES[0].drag[0];
    let bar = found.error_estimate.total() * drag;
    let error = found.bodies[0].velocity.x * drag - 1.0;
    within(error, bar + 2e-4, "the error bar, and 2e-4 of the file");
    within(bar, 1e-3, "the bar says something");
}

/// A sphere in a ball given by a file, and by its radius.
#[test]
fn a_domain_from_a_file_is_that_of_the_formula() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.stl");
    let ball = ellipsoid([4.0; 3], 48, Vec3::zeros());
    std::fs::write(&file, ball.to_stl()).unwrap();
    let of_domain = |domain: String| {
        let text = loaded("radius = 1, position = [1, 0.5, 0]").with("domain", domain);
        answer(&text.with("fem.symmetry", "off").scene())
    };
    let found = of_domain(format!("{{ kind = \"surface\", file = {file:?} }}"));
    let expected = of_domain("{ kind = \"ball\", radius = 4 }".to_owned());
    let bars = assert_same("domain", &found, &expected);
    within(
        bars,
        1e-2 * expected.bodies[0].velocity.norm(),
        "the bars say something",
    );
}

/// A channel, which is not convex: a body beside its bend is outside.
#[test]
fn bodies_outside_of_a_bent_channel_are_refused() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes/bent-channel.stl");
    let scene = |x: f64, y: f64, radius: f64| {
        let domain = format!("{{ kind = \"surface\", file = {file:?} }}");
        SceneText::new()
            .sphere("body", radius, [x, y, 0.0])
            .with("domain", domain)
            .try_scene()
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
