//! Meshes of files: followed by one method of motion after the other, then refused.

use std::path::{Path, PathBuf};

use mesh::TetMesh;
use models::{Configuration, FemModel, Hydrodynamics, InstantaneousSolution, ModelError, Remesh};
use scene::Scene;
use tempfile::TempDir;

use crate::scenes::three_spheres;

/// A coarse mesh of three spheres in a small ball, in a file.
fn file() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("spheres.msh");
    let own = three_spheres("domain = { kind = \"ball\", radius = 20 }\nfem.surface_size = 1.2");
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

/// Lengths of both arms, closing in small steps.
fn closing() -> impl Iterator<Item = f64> {
    (0..80).map(|k| 10.0 - 0.1 * f64::from(k))
}

/// The last length of both arms that a mesh motion reaches, and the error after it.
fn reached(file: &Path, motion: &str) -> (f64, ModelError) {
    let scene = scene(file, OWN_PARTS, motion);
    let mut model = FemModel::new(&scene).unwrap();
    let mut last = f64::INFINITY;
    for arm in closing() {
        match mesh_at(&mut model, &scene, [arm; 2]) {
            Ok(_) => last = arm,
            Err(error) => return (last, error),
        }
    }
    panic!("cells longer than the gap is wide are accepted");
}

#[test]
fn a_mesh_file_is_refused_only_after_all_methods_of_motion() {
    let (_folder, file) = file();
    let (biharmonic, refusal) = reached(&file, "fem.mesh_motion = \"biharmonic\"");
    let text = refusal.to_string();
    assert!(matches!(refusal, ModelError::MeshFileExhausted { .. }));
    assert!(
        text.contains("(biharmonic: ") && text.contains("fem.mesh_motion = \"auto\""),
        "{text}"
    );

    let (auto, refusal) = reached(&file, "");
    let text = refusal.to_string();
    assert!(auto <= biharmonic, "{auto} {biharmonic}");
    for method in ["biharmonic: ", "kanchi-masud: ", "rbf-cubic: "] {
        assert!(text.contains(method), "{text}");
    }
    assert!(!text.contains("fem.mesh_motion"), "{text}");
}

#[test]
fn the_mesh_of_a_file_depends_on_the_configuration_only() {
    let (_folder, file) = file();
    let scene = scene(&file, OWN_PARTS, "");
    let mut model = FemModel::new(&scene).unwrap();
    let shapes = [[10.0, 10.0], [6.0, 10.0], [6.0, 6.0], [9.0, 7.0]];
    let mut points = |lengths| {
        let mesh = mesh_at(&mut model, &scene, lengths).unwrap();
        mesh.points().to_vec()
    };
    let forward = shapes.map(&mut points);
    let mut backward = shapes;
    backward.reverse();
    let backward = backward.map(&mut points);
    assert!(forward.iter().eq(backward.iter().rev()));
}
