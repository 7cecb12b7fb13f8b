//! Scene files: those of the repository are valid, and written scenes read back unchanged.

use std::path::Path;

use proptest::prelude::*;
use scene::Scene;

use crate::overrides::{TWO, set};

#[test]
fn the_scenes_of_the_repository_are_valid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        // The folder also has the geometry of a mesh file.
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let outcome = Scene::read(&path, &[]);
        match outcome {
            Ok(scene) => assert_eq!(path.file_stem().unwrap().to_str().unwrap(), scene.name()),
            // This scene needs a mesh file that is not in the repository.
            Err(error) => assert!(
                error.to_string().contains("domain.file cannot be read"),
                "{error}"
            ),
        }
        seen += 1;
    }
    assert!(seen >= 5);
}

fn any_scene() -> impl Strategy<Value = String> {
    let body = (0.1_f64..1.0, -3.0_f64..3.0, -3.0_f64..3.0, -2.0_f64..2.0);
    (
        proptest::collection::vec(body, 1..6),
        1e-9_f64..1e9,
        proptest::collection::vec((0.0_f64..1.0, 3.0_f64..9.0, 1e-3_f64..1e3), 0..5),
        1_u32..9,
        prop::sample::select(vec!["clamped", "free", "lab"]),
        prop::sample::select(vec!["unbounded", "ball", "box"]),
    )
        .prop_map(|(bodies, viscosity, phases, cycles, arms, domain)| {
            let mut text = format!("fluid.viscosity = {viscosity}\ngait.cycles = {cycles}\ngait.arms = \"{arms}\"\n");
            text += match domain {
                "ball" => "domain = { kind = \"ball\", radius = 500 }\n",
                "box" => "domain = { kind = \"box\", size = [999.5, 999.5, 999.5] }\n",
                _ => "domain.kind = \"unbounded\"\n",
            };
            for (k, (radius, y, z, force)) in bodies.iter().enumerate() {
                // The distances along x are too large for any length of the gait to close the gaps.
                text += &format!(
                    "[[bodies]]\nname = \"b {k}\"\nradius = {radius}\nposition = [{}, {y}, {z}]\nforce = [{force}, 0, 1]\n",
                    20.0 * k as f64
                );
            }
            for k in 1..bodies.len() {
                text += &format!("[[links]]\nname = \"l{k}\"\nbody = \"b {k}\"\nto = \"b {}\"\n", k - 1);
            }
            if bodies.len() > 1 {
                for (pick, length, duration) in phases {
                    let joint = 1 + (pick * (bodies.len() - 1) as f64) as usize;
                    text += &format!("[[gait.phases]]\nlink = \"l{joint}\"\nlength = {length}\nduration = {duration}\n");
                }
            }
            text
        })
}

/// A file that is not regular never ends, or waits for a writer.
#[cfg(target_os = "linux")]
#[test]
fn devices_and_pipes_are_refused_as_files() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe.stl");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.unwrap().success());
    let pipe = pipe.to_str().unwrap();
    let refused = |text: &str| {
        let message = Scene::parse(text).expect_err(text).to_string();
        assert!(message.contains("not a regular file"), "{message}");
        assert!(message.starts_with("scene.toml:"), "{message}");
    };
    for file in ["/dev/zero", pipe] {
        assert!(Scene::read(file, &[]).is_err());
        refused(&format!("gait.file = {file:?}\n{TWO}").replace("gait.phases", "#"));
        refused(&format!(
            "domain = {{ kind = \"mesh\", file = {file:?}, walls = [\"w\"] }}"
        ));
    }
    refused(&format!(
        "domain = {{ kind = \"surface\", file = {pipe:?} }}"
    ));
}

#[test]
fn a_scene_file_named_by_dots_alone_has_a_name() {
    let folder = tempfile::tempdir().unwrap();
    for file in ["...toml", "..toml", "a..toml"] {
        let path = folder.path().join(file);
        std::fs::write(&path, TWO).unwrap();
        let scene = Scene::read(&path, &[]).unwrap();
        let name = if file.starts_with('a') { "a." } else { "scene" };
        assert_eq!(scene.name(), name);
    }
}

#[test]
fn a_changed_file_has_another_hash() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(
        at("scene.toml"),
        format!("gait.file = \"t.csv\"\n{TWO}").replace("gait.phases", "#"),
    )
    .unwrap();
    let mut files = ["time,arm\n0,10\n1,6\n", "time,arm\n0,10\n1,7\n"].map(|table| {
        std::fs::write(at("t.csv"), table).unwrap();
        Scene::read(at("scene.toml"), &[]).unwrap().source_files()
    });
    assert!(files[0][0].path.ends_with("t.csv"));
    assert_ne!(files[0][0].hash, files[1][0].hash);
    files[1][0].hash = files[0][0].hash;
    assert_eq!(files[0], files[1]);
    assert!(Scene::parse(TWO).unwrap().source_files().is_empty());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_written_scene_reads_back_unchanged(text in any_scene()) {
        let scene = Scene::parse(&text).unwrap();
        let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
        prop_assert_eq!(scene.bodies(), again.bodies());
        prop_assert_eq!(scene.domain(), again.domain());
        prop_assert_eq!(scene.gait(), again.gait());
        prop_assert_eq!(scene.articulation().joints(), again.articulation().joints());
        prop_assert_eq!(scene.articulation().arms(), again.articulation().arms());
        prop_assert_eq!((scene.viscosity(), scene.model(), scene.fem()), (again.viscosity(), again.model(), again.fem()));
        prop_assert_eq!(scene.to_toml().unwrap(), again.to_toml().unwrap());
    }

    #[test]
    fn an_override_of_a_number_equals_an_edit(x in 1e-6_f64..1e6) {
        let by_set = set(TWO, &[&format!("fluid.viscosity={x}")]).unwrap();
        let by_edit = Scene::parse(&format!("fluid.viscosity = {x}\n{TWO}")).unwrap();
        prop_assert_eq!(by_set.to_toml().unwrap(), by_edit.to_toml().unwrap());
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC{0,200}", key in "[a-z.\\[\\]0-9= ]{0,40}") {
        let _ = Scene::parse(&text);
        let _ = set(TWO, &[&key]);
        let _ = set(TWO, &[&format!("{key}={text}")]);
    }

    #[test]
    fn no_truncation_and_no_changed_byte_makes_the_reader_panic(at in 0_usize..400, byte in 0_u8..128) {
        let mut bytes = TWO.as_bytes().to_vec();
        let at = at % bytes.len();
        bytes[at] = byte;
        let _ = Scene::parse(&String::from_utf8_lossy(&bytes));
        let _ = Scene::parse(&String::from_utf8_lossy(&bytes[..at]));
    }
}
