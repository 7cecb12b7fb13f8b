//! Scenes.

use swimmer::Scene;

/// Reads a scene; one that is accepted is written and read again.
///
/// # Panics
/// If a scene cannot be written, or what was written is refused.
pub fn read(bytes: &[u8]) {
    if let Ok(text) = std::str::from_utf8(bytes)
        && let Ok(scene) = Scene::parse(text)
    {
        let written = scene.to_toml().expect("a scene is text");
        let again = Scene::parse(&written);
        assert!(again.is_ok(), "{:?} of\n{written}", again.err());
    }
}
