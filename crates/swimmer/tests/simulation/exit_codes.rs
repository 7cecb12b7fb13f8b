//! Unsupported scenes, and exit codes of errors.

use swimmer::models::ModelError;
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
fn unsupported_scenes_are_refused_with_the_alternative() {
    let massive = GOOD
        .replacen(
            "radius = 1\nposition = [0",
            "mass = 2\nradius = 1\nposition = [0",
            1,
        )
        .replace("kind = \"ball\"\nradius = 40", "kind = \"unbounded\"");
    let choose = |text: &str| swimmer::choose(&Scene::parse(text).unwrap()).map(drop);
    let error = choose(&massive).expect_err("unsupported");
    let fragment = "masses by finite elements in unbounded fluid is not supported; use spheres";
    assert!(error.to_string().contains(fragment), "{error}");
    assert!(error.is_bad_input());
    // Multipoles take it.
    assert!(choose(&massive.replace("kind = \"fem\"", "kind = \"multipole\"")).is_ok());
}

#[test]
fn every_scene_error_has_exit_code_2() {
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

#[test]
fn failed_methods_have_exit_code_3_and_interruptions_130() {
    let failed = ModelError::NoSolution { model: "test" };
    assert_eq!(SwimError::from(failed).exit_code(), 3);
    let unsupported = ModelError::Unsupported {
        what: "a wall".to_owned(),
        instead: "use a ball".to_owned(),
    };
    assert_eq!(SwimError::from(unsupported).exit_code(), 2);
    let interrupted = SwimError::Interrupted { phases: 1, all: 4 };
    assert_eq!(interrupted.exit_code(), 130);
}
