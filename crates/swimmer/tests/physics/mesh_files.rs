//! Strokes on a mesh from Gmsh.

use std::path::Path;

use swimmer::Scene;
use testkit::{exact, run, within};

/// With the harmonic motion of the mesh the stroke was refused.
#[test]
#[ignore = "slow: 60 s"]
fn the_default_stroke_on_a_mesh_from_gmsh_has_its_exact_displacement() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let file = root.join("crates/mesh/tests/fixtures/three-spheres-v41-binary.msh");
    let overrides = [format!("domain.file={}", file.display())];
    let outcome =
        run(&Scene::read(root.join("scenes/three-sphere-mesh.toml"), &overrides).unwrap());
    let error = outcome.displacement[1].x - exact::STROKE_IN_BALL_40.value;
    let bar = outcome.error_estimate.total();
    within(error, bar, "the error bar");
    within(bar, 1e-4, "the bar says something");
}
