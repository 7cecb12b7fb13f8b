//! Malformed scenes: each is refused with the place, the key and the remedy.

mod keys_and_values;
mod meaning;

use scene::Scene;

/// A valid scene; each case replaces a part of it.
pub const VALID: &str = r#"[fluid]
viscosity = 1

[domain]
kind = "ball"
radius = 40

[[bodies]]
name = "left"
radius = 1
position = [-10, 0, 0]

[[bodies]]
name = "centre"
radius = 1
position = [0, 0, 0]

[[links]]
name = "arm"
body = "left"
to = "centre"

[gait]
cycles = 2

[[gait.phases]]
link = "arm"
length = 6
duration = 1

[[gait.phases]]
link = "arm"
length = 10
duration = 1

[model]
kind = "fem"
tolerance = 1e-3

[fem]
rtol = 1e-8
"#;

#[test]
fn the_valid_scene_is_accepted() {
    Scene::parse(VALID).unwrap();
}

#[test]
fn deep_nesting_is_refused() {
    for open in ["[", "{a=", "[{a="] {
        let text = format!("{VALID}\nx = {}", open.repeat(50_000));
        let error = Scene::parse(&text).unwrap_err();
        assert!(error.to_string().len() < 1000);
    }
}

#[test]
fn malformed_scenes_are_refused_with_place_and_remedy() {
    for (part, by, fragments) in keys_and_values::CASES.iter().chain(meaning::CASES) {
        assert!(VALID.contains(part), "no such part: {part}");
        let text = VALID.replacen(part, by, 1);
        let error = Scene::parse(&text).expect_err(&format!("accepted: {by}"));
        let message = error.to_string();
        for fragment in *fragments {
            assert!(
                message.contains(fragment),
                "for {by:?}: {fragment:?} is not in: {message}"
            );
        }
        assert!(!message.contains('\n'), "more than one line: {message}");
    }
}

#[test]
fn scenes_without_bodies_or_phases_are_refused() {
    for (text, fragment) in [
        ("", "bodies is empty"),
        ("bodies = []", "bodies is empty"),
        ("[fluid]", "bodies is empty"),
        ("bodies = 3", "bodies must be a list of tables"),
        ("bodies = [3]", "bodies must be a list of tables"),
        (
            "bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] }]\ngait.phases = []",
            "gait.phases is empty",
        ),
        ("\u{feff}\u{feff}", "not valid TOML"),
    ] {
        let error = Scene::parse(text).expect_err(text);
        assert!(error.to_string().contains(fragment), "{text}: {error}");
    }
}

#[test]
fn a_second_cycle_that_starts_closer_is_checked_too() {
    let chain = VALID
        .replace(
            "[gait]",
            "[[bodies]]\nname = \"right\"\nradius = 1\nposition = [-4, 0, 0]\n\
            [[links]]\nname = \"b\"\nbody = \"right\"\nto = \"centre\"\n[gait]",
        )
        .replace("length = 6", "length = 6.5")
        .replace(
            "[model]",
            "[[gait.phases]]\nlink = \"b\"\nlength = 6\n[model]",
        );
    // In the first cycle the distance of 'left' and 'right' decreases to 2.5. Then 'right' moves
    // outwards by 2 and stays there.
    Scene::parse(&chain.replace("cycles = 2", "cycles = 1")).unwrap();
    let error = Scene::parse(&chain).unwrap_err().to_string();
    assert!(
        error.contains("'left' and 'right' touch or overlap in phase 1"),
        "{error}"
    );
}
