//! Unsupported scenes, and exit codes of errors.

use swimmer::models::ModelError;
use swimmer::{Scene, SceneError, SwimError};
use testkit::SceneText;

/// Two spheres with an arm in a ball, by finite elements.
fn good() -> SceneText {
    let text = testkit::chain(&["left", "centre"], &[-10.0, 0.0]).slide("arm", "left", "centre");
    let text = text.phases(&[("arm", 6.0), ("arm", 10.0)]).ball(40.0);
    text.model("fem", 1e-3).with("gait.cycles", 2)
}

#[test]
fn unsupported_scenes_are_refused_with_the_alternative() {
    let massive = good().set(&["bodies.centre.mass=2", "domain={ kind = \"unbounded\" }"]);
    let choose = |text: SceneText| swimmer::choose(&text.scene()).map(drop);
    let error = choose(massive.clone()).expect_err("unsupported");
    let fragment = "masses by finite elements in unbounded fluid is not supported; use spheres";
    assert!(error.to_string().contains(fragment), "{error}");
    assert!(error.is_bad_input());
    // Multipoles take it.
    assert!(choose(massive.with("model.kind", "multipole")).is_ok());
}

/// The model refuses it too, but as a failure of a method, and without the place.
#[test]
fn a_needle_of_ratio_1000_is_bad_input_with_its_place() {
    let needle = |half_length: f64| {
        Scene::parse(&format!(
            "bodies = [{{ name = \"a\", shape = \"spheroid\", radius = 1, \
             half_length = {half_length}, position = [0, 0, 0], force = [1, 0, 0] }}]"
        ))
        .unwrap()
    };
    for half_length in [1000.0, 501.0, 1.0 / 501.0] {
        let error = swimmer::choose(&needle(half_length)).map(drop).unwrap_err();
        let message = error.to_string();
        assert!(message.starts_with("scene.toml:1: a spheroid"), "{message}");
        assert!(
            message.contains("the limit is 500; make 'a' less slender"),
            "{message}"
        );
        assert_eq!(SwimError::from(error).exit_code(), 2);
    }
    // The limit is that of the model.
    let scene = needle(501.0);
    let refused = models::AxisymmetricModel::new(&scene).and_then(|mut m| m.describe(&scene));
    assert!(refused.unwrap_err().to_string().contains("limit of 500"));
}

#[test]
fn every_scene_error_has_exit_code_2() {
    let text = |text: &str| text.to_owned();
    let read = Scene::read(std::path::Path::new("no-such-scene.toml"), &[]);
    let placed = |x: &str| good().with("bodies.left.position", x).try_scene();
    let errors = [
        read.expect_err("there is no such file"),
        Scene::parse("[fluid").expect_err("not TOML"),
        Scene::parse("fluids = 1").expect_err("an unknown key"),
        Scene::parse("fluid.viscosity = -1").expect_err("a negative viscosity"),
        placed("[-2, 0, 0]").expect_err("touching bodies"),
        placed("[-39, 0, 0]").expect_err("a body at the wall"),
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
    let unsupported = ModelError::Unsupported {
        what: "a wall".to_owned(),
        instead: "use a ball".to_owned(),
    };
    for (error, code) in [
        (SwimError::from(ModelError::NoSolution { model: "test" }), 3),
        (SwimError::from(unsupported), 2),
        (SwimError::Interrupted { phases: 1, all: 4 }, 130),
    ] {
        assert_eq!(error.exit_code(), code, "{error}");
    }
}
