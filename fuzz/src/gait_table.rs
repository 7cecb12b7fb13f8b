//! Tables of gaits.

use swimmer::{Folder, Scene};

const SCENE: &str = r#"
model.kind = "rpy"
bodies = [
    { name = "a", radius = 1, position = [0, 0, 0] },
    { name = "b", radius = 1, position = [6, 0, 0] },
    { name = "c", radius = 1, position = [-6, 0, 0] },
]
links = [
    { name = "arm", body = "b", to = "a" },
    { name = "hinge", joint = "hinge", body = "c", to = "a", axis = [0, 0, 1] },
]
gait.file = "table.csv"
"#;

/// Reads a table with the columns `arm` and `hinge`, along each kind of interpolation.
///
/// # Panics
/// If the folder of temporary files cannot be written.
pub fn read(bytes: &[u8]) {
    let temporary = tempfile::tempdir().expect("a folder of temporary files");
    let folder = Folder::create(temporary.path()).expect("a folder");
    let write = |name: &str, contents: &[u8]| {
        std::fs::write(folder.path().join(name), contents).expect("a file of this folder");
    };
    write("table.csv", bytes);
    write("scene.toml", SCENE.as_bytes());
    for interpolation in ["linear", "cubic", "corner"] {
        let overrides = [format!("gait.interpolation={interpolation}")];
        drop(Scene::read(folder.path().join("scene.toml"), &overrides));
    }
}
