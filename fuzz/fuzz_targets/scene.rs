//! Any text is a scene or refused; what is a scene can be written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use swimmer::Scene;

fuzz_target!(|text: &str| {
    if let Ok(scene) = Scene::parse(text) {
        assert!(Scene::parse(&scene.to_toml().unwrap()).is_ok());
    }
});
