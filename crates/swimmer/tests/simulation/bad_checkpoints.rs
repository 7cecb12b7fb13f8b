//! Damaged checkpoints and checkpoints of other scenes are refused with the path and the defect.

use serde_json::{Value, json};
use swimmer::choose;
use swimmer::output::sealed;
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

/// The text of a checkpoint that says what `value` does, with the checksum that belongs to it.
fn text(value: &Value) -> String {
    sealed(value).unwrap()
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
    let interim = continue_from(&scene, text(&good).as_bytes()).unwrap();
    assert_eq!(interim.outcome.spans.len(), 1);
}

#[test]
fn texts_that_are_not_checkpoints_are_refused() {
    let (scene, good) = good();
    let text = text(&good);
    let half = &text.as_bytes()[..text.len() / 2];
    for (bytes, fragment) in [
        (&b""[..], "is damaged: EOF"),
        (b"hello", "is damaged: expected value at line 1"),
        (b"[]", "is damaged"),
        (b"{}", "missing field `version`"),
        (
            b"{\"version\": 2}",
            "is of version 2, this program reads version 11",
        ),
        (b"{\"version\": 11}", "missing field `scene`"),
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

/// A changed digit is another valid number, and the run would end with another trajectory.
#[test]
fn a_checkpoint_with_one_changed_number_is_refused() {
    let (scene, good) = good();
    let good = text(&good);
    let digits = good.match_indices(|c: char| c.is_ascii_digit());
    for (at, digit) in digits.step_by(41) {
        let mut bad = good.clone().into_bytes();
        bad[at] = if digit == "9" { b'1' } else { bad[at] + 1 };
        let error = continue_from(&scene, &bad).expect_err("changed");
        assert!(
            matches!(error, SwimError::Checkpoint { .. }),
            "{at}: {error}"
        );
    }
}

/// Checks that a scene with a file, of which another version is equal but for a comment, is not
/// resumed after the file has changed.
fn check_resume_after_change(toml: &str, file: &str, [bytes, changed]: [&[u8]; 2]) {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("scene.toml"), toml).unwrap();
    std::fs::write(at(file), bytes).unwrap();
    let read = || Scene::read(at("scene.toml"), &[]).unwrap();
    let out = Folder::create(at("out")).unwrap();
    let resumed = || {
        let (scene, mut model) = (read(), choose(&read()).unwrap().model);
        Checkpoint::read(at("out")).and_then(|one| one.restore(&scene, model.as_mut(), &at("out")))
    };
    let scene = read();
    let start = Interim::start(&scene).unwrap();
    let model = choose(&scene).unwrap().model;
    Checkpoint::new(&scene, &start.state, &start.outcome, model.as_ref(), &[])
        .unwrap()
        .write(&out)
        .unwrap();
    std::fs::write(at(file), changed).unwrap();
    let error = resumed().expect_err(file);
    let message = error.to_string();
    assert!(message.contains("other contents of the file"), "{message}");
    assert!(message.contains(&format!("{file}: put back")), "{message}");
    let viewed = Checkpoint::read(at("out")).unwrap().into_outcome(at("out"));
    assert!(viewed.is_err());
    std::fs::write(at(file), bytes).unwrap();
    resumed().expect(file);
}

#[test]
fn a_resume_after_a_changed_file_is_refused_with_its_name() {
    let phases = SCENE.find("gait.phases").unwrap();
    let toml = format!("{}gait.file = \"t.csv\"", &SCENE[..phases]);
    let table = ["time,arm\n0,6\n1,4\n2,6\n", "time,arm\n0,6\n1,4.5\n2,6\n"];
    check_resume_after_change(&toml, "t.csv", table.map(str::as_bytes));

    let toml = "domain = { kind = \"ball\", radius = 20 }\nmodel.kind = \"fem\"\n\
        gait.phases = [{ duration = 1 }]\n\
        bodies = [{ name = \"a\", shape = \"surface\", file = \"a.obj\", position = [0, 0, 0],\n\
        force = [1, 0, 0] }]";
    let surface = include_str!("../../../scene/tests/all/tetrahedron.obj");
    let commented = format!("{surface}# another version\n");
    check_resume_after_change(toml, "a.obj", [surface, &commented].map(str::as_bytes));
    // The format ignores two bytes after each of the four triangles, which follow 84 bytes.
    let mut triangles = vec![0; 84 + 4 * 50];
    triangles[80] = 4;
    let corners: [[f32; 3]; 4] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
    for (number, face) in [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
        .iter()
        .enumerate()
    {
        let numbers = face.iter().flat_map(|&corner: &usize| corners[corner]);
        for (k, number_bytes) in numbers.map(f32::to_le_bytes).enumerate() {
            let at = 84 + 50 * number + 12 + 4 * k;
            triangles[at..at + 4].copy_from_slice(&number_bytes);
        }
    }
    let mut commented = triangles.clone();
    commented[10] = b'!';
    let toml = toml.replace("a.obj", "a.stl");
    check_resume_after_change(&toml, "a.stl", [&triangles, &commented]);

    let toml = include_str!("../../../../scenes/three-sphere-mesh.toml");
    let mesh = include_bytes!("../../../mesh/tests/fixtures/three-spheres-v41-binary.msh");
    let commented = [&mesh[..], b"$Comments\nanother version\n$EndComments\n"].concat();
    check_resume_after_change(toml, "three-sphere.msh", [mesh, &commented]);
}

#[test]
fn values_that_do_not_fit_are_refused() {
    let (scene, good) = good();
    // Place, value, and what the message contains.
    let rows = r#"
/version 99 -> is of version 99, this program reads version 11
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
        refused(&scene, text(&bad).as_bytes(), fragment);
    }
    // More phases than the gait has.
    let mut bad = good.clone();
    let span = bad["outcome"]["spans"][0].clone();
    bad["outcome"]["spans"] = json!([span, span, span]);
    refused(&scene, text(&bad).as_bytes(), "3 completed phases of 2");
}

#[test]
fn missing_fields_are_named() {
    let (scene, good) = good();
    for field in "version scene files frames attitudes joints history outcome flows".split(' ') {
        let mut bad = good.clone();
        bad.as_object_mut().unwrap().remove(field);
        let fragment = format!("missing field `{field}`");
        refused(&scene, text(&bad).as_bytes(), &fragment);
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
        let changed = SCENE.replacen(from, to, 1);
        assert_ne!(changed, SCENE);
        let other = Scene::parse(&changed).unwrap();
        for fragment in ["belongs to another scene", fragment] {
            refused(&other, text(&good).as_bytes(), fragment);
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
