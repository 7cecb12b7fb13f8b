//! Scenes that are read but that no model computes, and the exit code of scenes that are refused.

use swimmer::{Scene, SceneError, SwimError};

/// A valid scene; each case replaces a part of it.
const GOOD: &str = r#"[fluid]
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
fn models_and_domains_that_are_not_built_are_named_with_what_to_use() {
    for (part, by, fragment) in [
        (
            "[[bodies]]",
            "[[bodies]]\nname = \"long\"\nshape = \"spheroid\"\nhalf_length = 2\nradius = 1\nposition = [0, 9, 0]\n[[bodies]]",
            "is not built yet; use model.kind = \"axisymmetric\"",
        ),
        (
            "radius = 1\nposition = [0",
            "mass = 2\nradius = 1\nposition = [0",
            "bodies[1].mass = 2 is not built yet; remove it",
        ),
    ] {
        let scene = Scene::parse(&GOOD.replacen(part, by, 1)).unwrap();
        let error = swimmer::choose(&scene).err().expect("not built");
        assert!(error.to_string().contains(fragment), "{error}");
        assert!(error.is_bad_input());
    }
}

#[test]
fn every_scene_error_ends_with_the_exit_code_of_bad_input() {
    let text = |text: &str| text.to_owned();
    let read = Scene::read(std::path::Path::new("no-such-scene.toml"), &[]);
    let errors = [
        read.expect_err("there is no such file"),
        Scene::parse("[fluid").expect_err("not TOML"),
        Scene::parse("fluids = 1").expect_err("an unknown key"),
        Scene::parse("fluid.viscosity = -1").expect_err("a negative viscosity"),
        Scene::parse(&GOOD.replace("-10", "-2")).expect_err("touching bodies"),
        Scene::parse(&GOOD.replace("-10", "-39")).expect_err("a body at the wall"),
        SceneError::NotApplicable {
            place: text("scene.toml"),
            problem: text("has no gait"),
        },
    ];
    for error in errors {
        let message = error.to_string();
        assert_eq!(SwimError::from(error).exit_code(), 2, "{message}");
    }
}
