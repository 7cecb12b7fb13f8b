//! Meshes of files: followed by one method of motion after the other, then refused.

use std::path::{Path, PathBuf};

use mesh::TetMesh;
use models::{
    Configuration, FemModel, History, Hydrodynamics, InstantaneousSolution, ModelError, Remesh,
};
use scene::Scene;
use tempfile::TempDir;

use crate::scenes::three_spheres;

/// A mesh of three spheres in a small ball, in a file.
fn file() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spheres.msh");
    let own = three_spheres("domain = { kind = \"ball\", radius = 20 }\nfem.surface_size = 0.55");
    let mut model = FemModel::new(&own).unwrap();
    mesh_at(&mut model, &own, [10.0, 10.0])
        .unwrap()
        .write(&path)
        .unwrap();
    (folder, path)
}

/// The three spheres in the mesh of a file, with the names of their boundary parts.
fn scene(file: &Path, parts: [&str; 3], more: &str) -> Scene {
    let mut text = format!(
        "domain = {{ kind = \"mesh\", file = {file:?}, walls = [\"outer\"] }}\nmodel.kind = \"fem\"\n{more}\n"
    );
    for ((name, x), part) in [("left", -10), ("centre", 0), ("right", 10)]
        .iter()
        .zip(parts)
    {
        text += &format!(
            "[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = [{x}, 0, 0]\nsurface = \"{part}\"\n"
        );
    }
    for name in ["left", "right"] {
        text += &format!("[[links]]\nname = \"{name}-arm\"\nbody = \"{name}\"\nto = \"centre\"\n");
    }
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Lengths at which the biharmonic and the harmonic motion are refused, the next one is not.
const OTHER_MOTION: [f64; 2] = [13.0, 13.0];

const OWN_PARTS: [&str; 3] = ["left", "centre", "right"];

fn mesh_at(model: &mut FemModel, scene: &Scene, lengths: [f64; 2]) -> Result<TetMesh, ModelError> {
    let configuration = Configuration {
        state: &scene.initial_state(),
        lengths: &lengths,
    };
    Ok(model.mesh(configuration)?.unwrap())
}

fn solve(model: &mut FemModel, scene: &Scene, lengths: [f64; 2]) -> InstantaneousSolution {
    let configuration = Configuration {
        state: &scene.initial_state(),
        lengths: &lengths,
    };
    model.solve_one(configuration, &[-1.0, 0.5]).unwrap()
}

/// The last configuration on a path that a mesh motion reaches, and the error after it.
fn reached(file: &Path, motion: &str, path: &[[f64; 2]]) -> ([f64; 2], ModelError) {
    let scene = scene(file, OWN_PARTS, motion);
    let mut model = FemModel::new(&scene).unwrap();
    let mut last = [f64::NAN; 2];
    for &lengths in path {
        match mesh_at(&mut model, &scene, lengths) {
            Ok(_) => last = lengths,
            Err(error) => return (last, error),
        }
    }
    panic!("{motion}: followed to the end, {last:?}");
}

#[test]
fn a_mesh_file_is_refused_only_after_all_methods_of_motion() {
    let (_folder, file) = file();
    // The outer spheres leave the ball of radius 20 at arms of 19.
    let opening: Vec<[f64; 2]> = (10..19).map(|arm| [f64::from(arm); 2]).collect();
    let biharmonic = "fem.mesh_motion = \"biharmonic\"";
    let (last, refusal) = reached(&file, biharmonic, &opening);
    let text = refusal.to_string();
    assert!(matches!(refusal, ModelError::MeshFileExhausted { .. }));
    assert!(
        text.contains("(biharmonic: ") && text.contains("fem.mesh_motion = \"auto\""),
        "{text}"
    );

    let (farther, refusal) = reached(&file, "", &opening);
    let text = refusal.to_string();
    assert!(farther > last, "{farther:?} {last:?}");
    for method in [
        "biharmonic: ",
        "kanchi-masud: ",
        "rbf-cubic: ",
        "rbf-linear: ",
    ] {
        assert!(text.contains(method), "{text}");
    }
    assert!(!text.contains("fem.mesh_motion"), "{text}");
}

#[test]
fn the_mesh_of_a_file_depends_on_the_configuration_only() {
    let (_folder, file) = file();
    let scene = scene(&file, OWN_PARTS, "");
    let mut model = FemModel::new(&scene).unwrap();
    let mut points = |lengths| {
        let mesh = mesh_at(&mut model, &scene, lengths).unwrap();
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
    let scene = scene(
        &file,
        OWN_PARTS,
        "fem = { rtol = 1e-4, estimates = \"off\" }",
    );
    let mut model = FemModel::new(&scene).unwrap();
    let first = solve(&mut model, &scene, OTHER_MOTION);
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
    let [expected, found] = [&mut model, &mut other].map(|m| solve(m, &scene, OTHER_MOTION));
    assert_eq!(found.bodies, expected.bodies);
    assert!(found.remeshed.is_none() && expected.remeshed.is_none());
}

#[test]
fn histories_with_more_motions_than_there_are_methods_are_refused() {
    let (_folder, file) = file();
    let [auto, one] =
        ["", "fem.mesh_motion = \"biharmonic\""].map(|motion| scene(&file, OWN_PARTS, motion));
    let mut model = FemModel::new(&auto).unwrap();
    mesh_at(&mut model, &auto, OTHER_MOTION).unwrap();
    let history = model.history().unwrap();
    let mut other = FemModel::new(&one).unwrap();
    assert!(other.restore(&history).is_err());
}

/// With the harmonic motion the default stroke on this mesh was refused.
#[test]
fn the_default_motion_follows_the_default_stroke_on_a_mesh_from_gmsh() {
    let file = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/meshes/ball_311k.msh"
    );
    if !Path::new(file).exists() {
        return;
    }
    let scene = scene(Path::new(file), ["sphere1", "sphere3", "sphere2"], "");
    let mut model = FemModel::new(&scene).unwrap();
    for shape in [[6.0, 10.0], [6.0, 6.0], [10.0, 6.0]] {
        mesh_at(&mut model, &scene, shape).unwrap();
    }
    // One method is in use, which is not recorded.
    assert_eq!(model.history().unwrap(), History::new(&[(); 0]).unwrap());
}
