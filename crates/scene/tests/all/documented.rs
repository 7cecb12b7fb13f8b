//! The table of keys agrees with the code, and the documentation with the table.

use std::path::Path;

use scene::keys::{KeyDefault, all, markdown};
use scene::{Document, Scene};

/// One entry of each list but `gait.harmonics`, with required keys only; the second body has an
/// axis.
const MINIMAL: &str = r#"
bodies = [
    { name = "sphere", radius = 1, position = [0, 0, 0] },
    { name = "spheroid", shape = "spheroid", radius = 1, half_length = 2, position = [9, 0, 0] },
]
links = [{ name = "arm", body = "sphere", to = "spheroid" }]
copies = [{ of = "sphere", positions = [[0, 50, 0]] }]
gait.phases = [{}]
"#;

/// The same with an entry of `gait.harmonics`, which exclude phases.
fn harmonic() -> String {
    let harmonics = "gait = { period = 8, harmonics = [{ link = \"arm\", amplitude = 1 }] }";
    MINIMAL.replace("gait.phases = [{}]", harmonics)
}

#[test]
fn writing_a_documented_default_into_a_scene_changes_nothing() {
    let harmonic = harmonic();
    for key in all() {
        let text = match key.path.starts_with("gait.harmonics") {
            true => &harmonic,
            false => MINIMAL,
        };
        let written = |settings: &[String]| {
            let mut document = Document::parse(text, "scene.toml").unwrap();
            settings.iter().for_each(|s| document.set(s).unwrap());
            Scene::from_document(document).unwrap().to_toml().unwrap()
        };
        let minimal = written(&[]);
        let KeyDefault::Value(value) = key.default else {
            continue;
        };
        let is_of_shape = key.path.ends_with(".axis") || key.path.ends_with(".orientation");
        let entry = if is_of_shape { ".1" } else { ".0" };
        let setting = format!("{}={value}", key.path.replace("[]", entry));
        assert_eq!(
            written(std::slice::from_ref(&setting)),
            minimal,
            "{setting}"
        );
    }
}

#[test]
fn keys_without_a_fixed_default_are_absent_from_a_minimal_scene() {
    let scene = Document::parse(MINIMAL, "scene.toml").unwrap();
    let text = Scene::from_document(scene).unwrap().to_toml().unwrap();
    let written: toml::Value = toml::from_str(&text).unwrap();
    for key in all().filter(|key| !key.path.contains("[]")) {
        let value = key
            .path
            .split('.')
            .try_fold(&written, |group, part| group.get(part));
        let has_default = matches!(key.default, KeyDefault::Value(_));
        assert_eq!(value.is_some(), has_default, "{}", key.path);
    }
}

#[test]
fn the_documentation_shows_all_keys() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scene.md");
    let page = std::fs::read_to_string(path).unwrap();
    assert!(
        page.contains(&markdown()),
        "replace the generated part of docs/scene.md by the output of \
         `cargo run -p microswim-scene --example key_table`"
    );
}
