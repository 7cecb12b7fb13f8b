//! Scenes as files: what is written reads back, and `--set` is the same as an edit.

use std::path::Path;

use proptest::prelude::*;
use swimmer::Scene;
use swimmer::scene::{Document, keys};

fn set(text: &str, assignments: &[&str]) -> Result<Scene, swimmer::SceneError> {
    let mut document = Document::parse(text, Path::new("scene.toml"))?;
    assignments
        .iter()
        .try_for_each(|assignment| document.set(assignment))?;
    Scene::from_document(document)
}

const TWO: &str = r#"
domain = { kind = "ball", radius = 40 }
bodies = [
    { name = "left", radius = 1, position = [-10, 0, 0] },
    { name = "1", radius = 1, position = [0, 0, 0] },
]
links = [{ name = "arm", body = "left", to = "1" }]
gait.phases = [{ link = "arm", length = 6 }]
"#;

#[test]
fn overrides_reach_every_kind_of_key() {
    let scene = set(
        TWO,
        &[
            "gait.cycles=3",
            "bodies.left.radius=0.5",
            "bodies[1].position = [0, 0, 5]",
            "fem.solver=direct",
            "fem.formulation=\"lagrange\"",
            "fluid.viscosity=2e-3",
            "gait.phases.0.length=7",
            "domain.kind=box",
            "domain.size=[100, 100, 100]",
        ],
    )
    .unwrap();
    assert_eq!(scene.gait.cycles, 3);
    assert_eq!(scene.bodies[0].bounding_radius(), 0.5);
    assert_eq!(scene.bodies[1].position.z, 5.0);
    assert_eq!(scene.fem.solver.word(), "direct");
    assert_eq!(scene.viscosity, 2e-3);
    assert_eq!(scene.gait.phases[0].change, Some((0, 7.0)));
    assert_eq!(scene.domain.kind().word(), "box");
}

#[test]
fn names_come_before_numbers_in_overrides() {
    // A body whose name is "1" is meant by bodies.1, wherever it stands.
    let text = TWO.replace("\"left\"", "\"7\"");
    let scene = set(
        &text,
        &[
            "bodies.1.radius=2",
            "bodies.7.radius=3",
            "bodies.0.force=[1, 0, 0]",
        ],
    )
    .unwrap();
    assert_eq!(scene.bodies[1].bounding_radius(), 2.0);
    assert_eq!(scene.bodies[0].bounding_radius(), 3.0);
    assert_eq!(scene.bodies[0].force.x, 1.0);
}

#[test]
fn bad_overrides_are_refused_with_the_same_checks() {
    for (assignment, fragment) in [
        ("gait.cycles", "has no value; write key=value"),
        ("gait.cycle=3", "did you mean 'gait.cycles'?"),
        (
            "bodies.middle.radius=1",
            "bodies has no entry 'middle'; there are left, 1",
        ),
        ("bodies.9.radius=1", "bodies has no entry '9'"),
        ("bodies.left.raduis=1", "did you mean 'bodies[].radius'?"),
        (
            "bodies.left.radius=-1",
            "must be a number greater than zero, not -1",
        ),
        (
            "bodies.left.radius=1,5",
            "must be a number greater than zero, not the text \"1,5\"",
        ),
        ("fluid.viscosity.x=1", "unknown key"),
        ("fluid=1", "fluid must be a table"),
        ("bodies=1", "bodies must be a list of tables"),
        (
            "bodies.left=1",
            "bodies[0] must be a table, written as [[bodies]]",
        ),
        ("=3", "unknown key"),
        (
            "fluid.viscosity=1\nfem.rtol=2",
            "must be a number greater than zero",
        ),
        ("bodies.left.radius=12", "touch or overlap"),
        ("gait.phases.0.link=leg", "names no link: \"leg\""),
    ] {
        let error = set(TWO, &[assignment]).expect_err(assignment);
        let message = error.to_string();
        assert!(message.contains(fragment), "{assignment}: {message}");
        assert_eq!(swimmer::SwimError::from(error).exit_code(), 2);
    }
}

#[test]
fn the_documented_defaults_are_the_ones_used() {
    let scene =
        Scene::parse("bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] }]").unwrap();
    let written: toml::Table = toml::from_str(&scene.to_toml()).unwrap();
    for key in keys::KEYS.iter().filter(|key| !key.path.contains("[]")) {
        let mut value = Some(&toml::Value::Table(written.clone())).cloned();
        for part in key.path.split('.') {
            value = value.and_then(|v| v.get(part).cloned());
        }
        match value {
            None => assert!(
                key.default.contains(' '),
                "{} has no default but documents {}",
                key.path,
                key.default
            ),
            Some(toml::Value::String(word)) => assert_eq!(word, key.default, "{}", key.path),
            Some(number) => {
                let number = number
                    .as_float()
                    .or(number.as_integer().map(|i| i as f64))
                    .unwrap();
                assert_eq!(number, key.default.parse::<f64>().unwrap(), "{}", key.path);
            }
        }
    }
}

#[test]
fn the_scenes_of_the_repository_are_valid() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut seen = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let outcome = Scene::read(&path, &[]);
        match outcome {
            Ok(scene) => assert_eq!(path.file_stem().unwrap().to_str().unwrap(), scene.name),
            // A scene on a mesh file that the reader has to bring.
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
                // Far enough along x that no length of the gait brings two of them together.
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
                    let link = 1 + (pick * (bodies.len() - 1) as f64) as usize;
                    text += &format!("[[gait.phases]]\nlink = \"l{link}\"\nlength = {length}\nduration = {duration}\n");
                }
            }
            text
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_scene_reads_back_what_was_written(text in any_scene()) {
        let scene = Scene::parse(&text).unwrap();
        let again = Scene::parse(&scene.to_toml()).unwrap();
        prop_assert_eq!(&scene.bodies, &again.bodies);
        prop_assert_eq!(&scene.domain, &again.domain);
        prop_assert_eq!(&scene.gait, &again.gait);
        prop_assert_eq!(scene.articulation.links(), again.articulation.links());
        prop_assert_eq!(scene.articulation.arms(), again.articulation.arms());
        prop_assert_eq!((scene.viscosity, scene.model, scene.fem), (again.viscosity, again.model, again.fem));
        prop_assert_eq!(scene.to_toml(), again.to_toml());
    }

    #[test]
    fn setting_a_number_is_the_same_as_writing_it(x in 1e-6_f64..1e6) {
        let by_set = set(TWO, &[&format!("fluid.viscosity={x}")]).unwrap();
        let by_edit = Scene::parse(&format!("fluid.viscosity = {x}\n{TWO}")).unwrap();
        prop_assert_eq!(by_set.to_toml(), by_edit.to_toml());
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "\\PC{0,200}", key in "[a-z.\\[\\]0-9= ]{0,40}") {
        let _ = Scene::parse(&text);
        let _ = set(TWO, &[&key]);
        let _ = set(TWO, &[&format!("{key}={text}")]);
    }

    #[test]
    fn no_cut_or_changed_byte_makes_the_reader_panic(at in 0_usize..400, byte in 0_u8..128) {
        let mut bytes = TWO.as_bytes().to_vec();
        let at = at % bytes.len();
        bytes[at] = byte;
        let _ = Scene::parse(&String::from_utf8_lossy(&bytes));
        let _ = Scene::parse(&String::from_utf8_lossy(&bytes[..at]));
    }
}
