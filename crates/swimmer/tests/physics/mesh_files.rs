//! Strokes on a mesh from Gmsh.

use std::path::Path;

use swimmer::{Method, Scene, choose, simulate};

/// With the harmonic motion of the mesh the stroke was refused.
#[test]
#[ignore = "slow: 60 s"]
fn the_default_stroke_on_a_mesh_from_gmsh_has_its_exact_displacement() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = root.join("crates/mesh/tests/fixtures/three-spheres-v41-binary.msh");
    let scene = Scene::read(
        &root.join("scenes/three-sphere-mesh.toml"),
        &[format!("domain.file={}", file.display())],
    )
    .unwrap();
    let mut model = choose(&scene).unwrap().model;
    let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ()).unwrap();
    // Spectral, ball of 40.
    let error = (outcome.displacement[1].x - 0.1604180159643671).abs();
    let bar = outcome.error_estimate.total();
    assert!(error <= bar && bar < 1e-4, "{error:e} {bar:e}");
}
