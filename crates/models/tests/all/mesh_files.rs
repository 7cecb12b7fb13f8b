//! Meshes of files, followed by one method of motion after the other.

use std::path::{Path, PathBuf};

use mesh::{LinearTets, TetMesh, Vec3};
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use models::{FemModel, History, Hydrodynamics, InstantaneousSolution, ModelError, Remesh};
use scene::Scene;
use tempfile::TempDir;

use testkit::{SceneText, solve_at, within};

use crate::scenes::{solve_at_start, three_spheres};

/// A mesh of three spheres in a small ball, in a file.
pub fn file() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spheres.msh");
    let mut model = FemModel::new(&own_mesh()).unwrap();
    let mesh = mesh_at(&mut model, [10.0, 10.0]).unwrap();
    mesh.write(&path).unwrap();
    (folder, path)
}

/// The same scene with our own mesh.
pub fn own_mesh() -> Scene {
    three_spheres()
        .ball(20.0)
        .with("fem.surface_size", 0.55)
        .scene()
}

/// The domain in the mesh of a file.
pub fn in_file(text: SceneText, file: &Path) -> SceneText {
    let domain = format!("{{ kind = \"mesh\", file = {file:?}, walls = [\"outer\"] }}");
    text.with("domain", domain).with("model.kind", "fem")
}

/// The three spheres in the mesh of a file, with the names of their boundary parts.
pub fn scene(file: &Path, parts: [&str; 3], settings: &[&str]) -> Scene {
    let bodies = OWN_PARTS.iter().zip(parts);
    let text = bodies.fold(three_spheres(), |text, (name, part)| {
        text.with(&format!("bodies.{name}.surface"), part)
    });
    in_file(text, file).set(settings).scene()
}

/// Lengths at which the biharmonic and the harmonic motion are refused, the next one is not.
pub const OTHER_MOTION: [f64; 2] = [16.0, 10.0];

pub const OWN_PARTS: [&str; 3] = ["left", "centre", "right"];

pub fn mesh_at(model: &mut FemModel, shape: [f64; 2]) -> Result<TetMesh, ModelError> {
    let state = model.scene().initial_state();
    let configuration = testkit::at(&state, &shape);
    Ok(model.mesh(configuration)?.unwrap())
}

pub fn solve(model: &mut FemModel, shape: [f64; 2]) -> InstantaneousSolution {
    solve_at(model, &shape, &[-1.0, 0.5])
}

#[test]
fn the_mesh_of_a_file_depends_on_the_configuration_only() {
    let (_folder, file) = file();
    let scene = scene(&file, OWN_PARTS, &[]);
    let mut model = FemModel::new(&scene).unwrap();
    let mut points = |lengths| {
        let mesh = mesh_at(&mut model, lengths).unwrap();
        mesh.points().to_vec()
    };
    let shapes = [[10.0, 10.0], [6.0, 10.0], OTHER_MOTION, [8.0, 7.0]];
    let forward: Vec<_> = shapes.iter().map(|&shape| points(shape)).collect();
    let backward: Vec<_> = shapes.iter().rev().map(|&shape| points(shape)).collect();
    assert!(forward.iter().eq(backward.iter().rev()));
}

/// Resumed runs reported the methods of motion a second time.
#[test]
fn a_change_of_motion_is_reported_once_and_restored_bitwise() {
    let (_folder, file) = file();
    let scene = scene(&file, OWN_PARTS, &["fem.rtol=1e-4", "fem.estimates=off"]);
    let mut model = FemModel::new(&scene).unwrap();
    let first = solve(&mut model, OTHER_MOTION);
    let Some(Remesh::Motion { name, tried }) = first.remeshed else {
        panic!("{:?}", first.remeshed);
    };
    assert_eq!(name, "rbf-cubic");
    assert!(
        tried.contains("biharmonic: ") && tried.contains("kanchi-masud: "),
        "{tried}"
    );

    let history = model.history().unwrap();
    model.restore(&history).unwrap();
    let mut other = FemModel::new(&scene).unwrap();
    other.restore(&history).unwrap();
    assert_eq!(other.history().unwrap(), history);
    let [expected, found] = [&mut model, &mut other].map(|m| solve(m, OTHER_MOTION));
    assert_eq!(found.bodies, expected.bodies);
    assert!(found.remeshed.is_none() && expected.remeshed.is_none());
}

/// With the harmonic motion the default stroke on this mesh was refused.
#[test]
fn the_default_motion_follows_the_default_stroke_on_a_mesh_from_gmsh() {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../mesh/tests/fixtures/three-spheres-v41-binary.msh"
    );
    let scene = scene(Path::new(file), ["sphere1", "sphere3", "sphere2"], &[]);
    let mut model = FemModel::new(&scene).unwrap();
    for shape in [[6.0, 10.0], [6.0, 6.0], [10.0, 6.0]] {
        mesh_at(&mut model, shape).unwrap();
    }
    // One method is in use, which is not recorded.
    assert_eq!(model.history().unwrap(), History::new(&[(); 0]).unwrap());
}

/// A sphere in a ball, with one vertex so close to the sphere that a curved cell is below the limit
/// for moved meshes, 0.2.
fn poor_mesh() -> TetMesh {
    let [sphere, outer] = [1.0, 5.0].map(|radius| Sphere {
        centre: Vec3::zeros(),
        radius,
    });
    let body = MeshedBody {
        name: "sphere",
        surface: &sphere,
        size: 0.6,
    };
    let container = Container::Ball(outer);
    let good = generate(&[body], &container, &GenerateParams::default())
        .unwrap()
        .mesh;
    let curved = |tets: LinearTets| TetMesh::curved(tets, &[("sphere", &sphere)]);
    let on_sphere = |v: u32| (good.points[v as usize].norm() - 1.0).abs() < 1e-9;
    let is_on_facet = |tet: &&[u32; 4]| tet.iter().filter(|&&v| on_sphere(v)).count() == 3;
    let cell = good.tets.iter().find(is_on_facet).unwrap();
    let apex = *cell.iter().find(|&&v| !on_sphere(v)).unwrap();
    let others = cell.iter().filter(|&&v| v != apex);
    let facet = others.map(|&v| good.points[v as usize]).sum::<Vec3>() / 3.0;
    let from = good.points[apex as usize];
    for part in 1..100 {
        let mut tets = good.clone();
        tets.points[apex as usize] = from + 0.01 * f64::from(part) * (facet - from);
        let mesh = curved(tets).expect("a valid mesh on the way to a poor one");
        if mesh.quality().min_jacobian < 0.19 {
            return mesh;
        }
    }
    panic!("no poor mesh");
}

/// A mesh with a quality below the limit for moved meshes was replaced at each solve, without any
/// improvement.
#[test]
fn bug_a_reference_mesh_of_low_quality_was_not_kept() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sphere.msh");
    poor_mesh().write(&file).unwrap();
    let keys = "radius = 1, surface = \"sphere\", force = [1, 0, 0]";
    let text = in_file(SceneText::new().shape("sphere", keys, [0; 3]), &file);
    let mut model = FemModel::new(&text.with("fem.estimates", "off").scene()).unwrap();
    let mut remeshed = || solve_at(&mut model, &[], &[]).remeshed;
    // The file's mesh, by the first method of motion; then the same again.
    assert_eq!([remeshed(), remeshed()], [None, None]);
}

/// A sphere, a turned ellipsoid and a capsule in a ball, meshed by Gmsh with curved cells, and the
/// same bodies in our own mesh: the answers agree within their bars.
#[test]
fn bodies_of_a_second_order_file_move_as_those_of_our_own_mesh() {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../mesh/tests/fixtures/mixed-bodies-order2-v41-binary.msh"
    );
    let angle = 0.6 / 3.0_f64.sqrt();
    let orientation = format!("orientation = [{angle}, {angle}, {angle}]");
    let ellipsoid = format!("shape = \"ellipsoid\", semi_axes = [1.5, 1, 0.8], {orientation}");
    let text = SceneText::new()
        .sphere("sphere", 1.0, [-6, 0, 0])
        .shape("ellipsoid", &ellipsoid, [0; 3])
        .shape(
            "capsule",
            "shape = \"capsule\", radius = 1, half_length = 2",
            [6, 0, 0],
        )
        .slide("a", "sphere", "ellipsoid")
        .slide("b", "capsule", "ellipsoid")
        .set(&["model.kind=fem", "fem.size_factor=1.5"]);
    let velocities = |text: SceneText| {
        let mut model = FemModel::new(&text.scene()).unwrap();
        let solution = solve_at_start(&mut model, &[-1.0, 0.5]);
        let bar = solution.error_estimate.total();
        (solution.response.bodies, bar)
    };
    let parts = ["sphere", "ellipsoid", "capsule"];
    let with_parts = parts.iter().fold(text.clone(), |text, name| {
        text.with(&format!("bodies.{name}.surface"), name)
    });
    let (of_file, file_bar) = velocities(in_file(with_parts, Path::new(file)));
    let (own, own_bar) = velocities(text.ball(20.0));
    for (a, b) in of_file.iter().zip(&own) {
        let difference = (a.velocity - b.velocity).norm();
        within(difference, file_bar + own_bar, "both error bars");
    }
    within(own_bar, 1e-3, "the bar says something");
}

/// In units of the radius of the body they overflow.
#[test]
fn bug_points_that_are_not_finite_were_a_failed_method_without_a_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("far.msh");
    let text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
        $PhysicalNames\n1\n2 1 \"outer\"\n$EndPhysicalNames\n\
        $Nodes\n4\n1 0 0 0\n2 1.7e308 0 0\n3 1.7e308 1 0\n4 0 0 1\n$EndNodes\n\
        $Elements\n5\n1 2 2 1 1 1 2 3\n2 2 2 1 1 1 2 4\n3 2 2 1 1 1 3 4\n4 2 2 1 1 2 3 4\n\
        5 4 2 2 1 1 2 3 4\n$EndElements\n";
    std::fs::write(&path, text).unwrap();
    let scene = in_file(testkit::chain(&["a"], &[0.0]), &path).with("bodies.a.surface", "outer");
    let scene = scene.with("bodies.a.radius", 0.01);
    let error = FemModel::new(&scene.scene()).map(drop).unwrap_err();
    let message = error.to_string();
    assert!(
        message.starts_with(&path.display().to_string()),
        "{message}"
    );
    assert!(message.contains("not finite"), "{message}");
    assert!(error.is_bad_input());
}

/// The facets of the outer sphere are inside it: by the sagitta `h² / 8 R` of half an edge.
#[test]
fn bug_walls_of_a_mesh_had_no_clearance() {
    let (_folder, file) = file();
    let scene = scene(&file, OWN_PARTS, &[]);
    let body = &scene.bodies()[0];
    let clearance = |x: f64| {
        let pose = nalgebra::Isometry3::translation(x, 0.0, 0.0);
        scene.domain().clearance(body, &pose)
    };
    let sagitta = 8.0_f64.powi(2) / (8.0 * 20.0);
    for x in [-10.0, -18.0] {
        let exact = 20.0 - 1.0 + x;
        let found = clearance(x);
        assert!(
            (exact - sagitta..=exact + 1e-9).contains(&found),
            "{x}: {found}"
        );
    }
    assert!(clearance(-19.1) < 0.0);
}
