//! Damaged checkpoints and checkpoints of other scenes are refused with the path and the defect.

use serde_json::{Value, json};
use swimmer::choose;
use swimmer::{
    Checkpoint, Folder, Interim, Method, Observer, Outcome, Scene, SpanResult, SwimError,
    checkpoint, simulate,
};

const SCENE: &str = r#"
    domain.kind = "unbounded"
    model = { kind = "rpy", tolerance = 1e-2 }
    bodies = [
        { name = "a", radius = 1, position = [0, 0, 0] },
        { name = "b", radius = 1, position = [6, 0, 0] },
    ]
    links = [{ name = "arm", body = "b", to = "a" }]
    gait.phases = [{ link = "arm", length = 4 }, { link = "arm", length = 6 }]
"#;

/// Keeps the checkpoint after the first phase span.
struct Keep<'a>(&'a Scene, Option<Value>);

impl Observer for Keep<'_> {
    fn span_done(
        &mut self,
        _: &swimmer::PhaseSpan,
        result: &SpanResult,
        so_far: &Outcome,
        model: &mut dyn models::Hydrodynamics,
    ) -> Result<(), SwimError> {
        let checkpoint = Checkpoint::new(self.0, &result.end, so_far, model, &[])?;
        self.1
            .get_or_insert(serde_json::to_value(&checkpoint).unwrap());
        Ok(())
    }
}

/// The scene and its checkpoint after the first of two phases.
fn good() -> (Scene, Value) {
    let scene = Scene::parse(SCENE).unwrap();
    let mut keep = Keep(&scene, None);
    let mut model = choose(&scene).unwrap().model;
    simulate(&scene, model.as_mut(), Method::Collocation, &mut keep).unwrap();
    let value = keep.1.unwrap();
    (scene, value)
}

/// Restores a run from the bytes of a checkpoint.
fn continue_from(scene: &Scene, bytes: &[u8]) -> Result<Interim, SwimError> {
    let temporary = tempfile::tempdir().unwrap();
    let folder = Folder::create(temporary.path()).unwrap();
    std::fs::write(folder.path().join(checkpoint::FILE), bytes).unwrap();
    let mut model = choose(scene).unwrap().model;
    let (interim, _) =
        Checkpoint::read(folder.path())?.restore(scene, model.as_mut(), folder.path())?;
    Ok(interim)
}

#[track_caller]
fn refused(scene: &Scene, bytes: &[u8], fragment: &str) {
    let error = continue_from(scene, bytes).expect_err(fragment);
    let message = error.to_string();
    assert!(
        message.contains(fragment),
        "{fragment:?} is not in: {message}"
    );
    assert!(message.contains(checkpoint::FILE), "{message}");
    assert!(!message.contains('\n'), "{message}");
    assert!(message.len() < 1000, "{message}");
}

#[test]
fn a_valid_checkpoint_is_restored() {
    let (scene, good) = good();
    let interim = continue_from(&scene, good.to_string().as_bytes()).unwrap();
    assert_eq!(interim.outcome.spans.len(), 1);
}

#[test]
fn texts_that_are_not_checkpoints_are_refused() {
    let (scene, good) = good();
    let text = good.to_string();
    let half = &text.as_bytes()[..text.len() / 2];
    for (bytes, fragment) in [
        (&b""[..], "is damaged: EOF"),
        (b"hello", "is damaged: expected value at line 1"),
        (b"[]", "is damaged"),
        (b"{}", "missing field `version`"),
        (b"{\"version\": 2}", "missing field `scene`"),
        (half, "is damaged: EOF"),
        (b"\xff\xfe{}", "UTF-8"),
        (b"nan", "is damaged"),
        // A parser without a limit on the depth would overflow the stack.
        (&[b'['; 100_000], "is damaged: "),
    ] {
        refused(&scene, bytes, fragment);
    }
    let twice = text.clone() + &text;
    refused(&scene, twice.as_bytes(), "trailing characters");
    let huge = text.replacen("\"work\":", "\"work\":1e999, \"was\":", 1);
    assert_ne!(huge, text);
    refused(&scene, huge.as_bytes(), "number out of range");
}

#[test]
fn values_that_do_not_fit_are_refused() {
    let (scene, good) = good();
    // Place, value, and what the message contains.
    let rows = r#"
/version 99 -> is of version 99, this program reads version 4
/version "1" -> invalid type: string
/version -1 -> invalid value: integer `-1`
/scene "" -> another scene: one of the two has more keys
/scene 3 -> invalid type: integer `3`
/frames [] -> 0 frames, 2 bodies
/frames null -> invalid type: null
/frames/0/translation/0 null -> invalid type: null
/frames/0/rotation [0.0, 0.0, 0.0, 0.0] -> the norm of a quaternion differs from 1 by 1e0
/frames/0/rotation [0.0, 0.0, 0.0, 2.0] -> the norm of a quaternion differs from 1 by 1e0
/attitudes [] -> 1 frames, 0 bodies
/joints [1.0] -> does not fit the scene
/attitudes/1 [1e200, 0.0, 0.0, 0.0] -> the norm of a quaternion differs from 1
/history {} -> the history of the model is not empty
/flows [[0.0]] -> invalid length 1
/outcome [] -> is damaged
/outcome/spans/0/displacement [] -> does not fit the scene
/outcome/spans/0/joints [7] -> does not fit the scene
/outcome/spans/0/solves -3 -> invalid value: integer `-3`
/outcome/displacement [] -> does not fit the scene
/outcome/samples [] -> does not fit the scene
/outcome/samples/0/poses [] -> does not fit the scene
/outcome/samples/0/shape [] -> does not fit the scene
/outcome/samples/1/bodies [] -> does not fit the scene
/outcome/curve [] -> does not fit the scene
/outcome/curve/3/1 [] -> does not fit the scene
/outcome/mesh_error [[0.0, 0.0, 0.0]] -> does not fit the scene
/outcome/tolerance_met "yes" -> expected a boolean
"#;
    for row in rows.trim().lines() {
        let (change, fragment) = row.split_once(" -> ").unwrap();
        let (place, value) = change.split_once(' ').unwrap();
        let mut bad = good.clone();
        *bad.pointer_mut(place).expect(place) = serde_json::from_str(value).unwrap();
        refused(&scene, bad.to_string().as_bytes(), fragment);
    }
    // More phases than the gait has.
    let mut bad = good.clone();
    let span = bad["outcome"]["spans"][0].clone();
    bad["outcome"]["spans"] = json!([span, span, span]);
    let bad = bad.to_string();
    refused(&scene, bad.as_bytes(), "3 completed phases of 2");
}

#[test]
fn missing_fields_are_named() {
    let (scene, good) = good();
    for field in "version scene frames attitudes joints history outcome flows".split(' ') {
        let mut bad = good.clone();
        bad.as_object_mut().unwrap().remove(field);
        let fragment = format!("missing field `{field}`");
        refused(&scene, bad.to_string().as_bytes(), &fragment);
    }
}

#[test]
fn a_checkpoint_of_another_scene_is_refused_with_the_difference() {
    let (_, good) = good();
    for (from, to, fragment) in [
        ("length = 4", "length = 4.5", "length = 4"),
        ("radius = 1", "radius = 0.5", "radius"),
        ("kind = \"rpy\"", "kind = \"oseen\"", "oseen"),
        ("1e-2", "1e-3", "tolerance"),
    ] {
        let text = SCENE.replacen(from, to, 1);
        assert_ne!(text, SCENE);
        let other = Scene::parse(&text).unwrap();
        for fragment in ["belongs to another scene", fragment] {
            refused(&other, good.to_string().as_bytes(), fragment);
        }
    }
}

#[test]
fn a_folder_without_a_checkpoint_is_refused() {
    let temporary = tempfile::tempdir().unwrap();
    let error = Checkpoint::read(temporary.path()).unwrap_err();
    assert!(matches!(error, SwimError::Read { .. }), "{error}");
    assert!(error.to_string().contains(checkpoint::FILE), "{error}");
}
