//! Runs of fluids with inertia that are interrupted and resumed.

use std::path::Path;

use scene::Scene;
use serde_json::{Value, json};
use swimmer::output::sealed;
use swimmer::{SwimError, checkpoint, run};
use testkit::interrupted;

/// A sphere that is released in the meridian plane, from Stokes flow: the gait has no corner.
const RELEASED: &str = r#"
    fluid = { density = 1, inertia = "full", start = "stokes" }
    domain = { kind = "ball", radius = 5 }
    model.tolerance = 0.2
    gravity = [0, 0, 4.5]
    bodies = [{ name = "ball", radius = 1, density = 2, position = [0, 0, 0] }]
    gait.phases = [{ duration = 0.3 }, { duration = 0.2 }, { duration = 0.1 }]
"#;

/// Two spheres whose gap closes so far that there is a new mesh, and opens again.
const PAIR: &str = r#"
    fluid = { density = 1, inertia = "full", time_step = 0.25 }
    domain = { kind = "ball", radius = 7 }
    model = { kind = "fem", tolerance = 0.1 }
    fem.size_factor = 1.75
    bodies = [
        { name = "large", radius = 1.5, position = [-2, 0, 0] },
        { name = "small", radius = 1, position = [2.5, 0, 0] },
    ]
    links = [{ name = "arm", body = "small", to = "large" }]
    gait.phases = [{ link = "arm", length = 3 }, { link = "arm", length = 4.5 }]
"#;

fn parsed(text: &str) -> Scene {
    Scene::parse(text).unwrap()
}

fn read(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join(checkpoint::FILE)).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Interrupts a run after `phases` phases; the checkpoint is in the folder.
fn interrupt(text: &str, phases: usize, folder: &Path) {
    assert_eq!(interrupted(parsed(text), phases, folder), phases);
}

/// Everything of a checkpoint but the seconds, which differ.
fn numbers(mut checkpoint: Value) -> Value {
    checkpoint["outcome"]["seconds"].take();
    checkpoint["checksum"].take();
    for span in checkpoint["outcome"]["spans"].as_array_mut().unwrap() {
        span["seconds"].take();
    }
    checkpoint
}

/// A run that is interrupted after each number of phases has the numbers of one without
/// interruption, to the last bit.
#[track_caller]
fn is_resumed(text: &str, interrupted: &[usize]) {
    let whole = tempfile::tempdir().unwrap();
    run(parsed(text), whole.path(), false, &mut (), &mut ()).unwrap();
    let whole = numbers(read(whole.path()));
    assert!(whole["fluid"].is_object());
    for &phases in interrupted {
        let folder = tempfile::tempdir().unwrap();
        interrupt(text, phases, folder.path());
        run(parsed(text), folder.path(), true, &mut (), &mut ()).unwrap();
        // Bit by bit: numbers are written with the digits that restore them.
        assert!(numbers(read(folder.path())) == whole, "{phases}");
    }
}

#[test]
fn a_resumed_run_in_the_meridian_plane_has_the_same_bits() {
    is_resumed(RELEASED, &[1, 2]);
}

/// The time of the fluid goes on from that of the search for the periodic state.
#[test]
fn a_resumed_run_from_a_periodic_state_has_the_same_bits() {
    let text = RELEASED
        .replace("gravity = [0, 0, 4.5]\n", "")
        .replace("density = 2,", "slip = { b1 = 1e-3, axis = [0, 0, 1] },")
        .replace("gait.phases", "gait.periodic = true\n    gait.phases");
    is_resumed(&text, &[1]);
}

#[test]
fn a_resumed_run_in_space_has_the_same_bits_across_new_meshes() {
    is_resumed(PAIR, &[1]);
    let folder = tempfile::tempdir().unwrap();
    interrupt(PAIR, 1, folder.path());
    let checkpoint = read(folder.path());
    let generated = checkpoint.pointer("/fluid/fluid/with_companion/0/spatial/0/poses/0");
    let at_start = parsed(PAIR).bodies()[0].position.x;
    let x = generated.and_then(|pose| pose["translation"][0].as_f64());
    assert!(
        x.is_some_and(|x| x != at_start),
        "no new mesh: {generated:?}"
    );
}

/// A run that was repeated with inertia goes on with it, although its scene leaves that open.
#[test]
fn a_run_that_has_decided_for_inertia_is_resumed_with_it() {
    let automatic = RELEASED.replace("\"full\"", "\"auto\"");
    let folder = tempfile::tempdir().unwrap();
    // Three phases without inertia, and one with it.
    assert_eq!(interrupted(parsed(&automatic), 4, folder.path()), 1);
    let resumed = run(parsed(&automatic), folder.path(), true, &mut (), &mut ()).unwrap();
    let whole = swimmer::run_without_files(parsed(RELEASED), &mut ()).unwrap();
    assert_eq!(resumed.outcome.displacement, whole.outcome.displacement);
}

/// A checksum that belongs to the changed text keeps nothing out.
#[test]
fn flows_that_do_not_fit_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    interrupt(RELEASED, 1, folder.path());
    let good = read(folder.path());
    let plane = "/fluid/fluid/with_companion/0/meridian";
    let level = format!("{plane}/levels/0");
    for (place, value, fragment) in [
        ("/fluid", json!(null), "the flow of its fluid"),
        ("/fluid/length", json!(-1.0), "another time"),
        ("/fluid/velocity_error", json!(-1.0), "another time"),
        ("/fluid/fluid", json!({"round": []}), "unknown variant"),
        (&format!("{plane}/centres"), json!([]), "centres of bodies"),
        (&format!("{plane}/centres"), json!([4.5]), "does not fit"),
        (
            &format!("{plane}/start"),
            json!([0.0, 1.0]),
            "displacements",
        ),
        (&format!("{plane}/levels"), json!([]), "between 1 and 3"),
        (&format!("{plane}/largest"), json!(-1.0), "zero or positive"),
        (&format!("{level}/time"), json!(7.0), "another time"),
        (
            "/fluid/fluid/with_companion/1/meridian/levels/0/time",
            json!(7.0),
            "another time",
        ),
        (&format!("{level}/time"), json!(-7.0), "between 1 and 3"),
        (&format!("{level}/nodes"), json!([[0.0, 1.0]]), "of nodes"),
        (
            &format!("{level}/velocities"),
            json!([]),
            "velocities of bodies",
        ),
        (&format!("{level}/fields/pressure"), json!([]), "pressures"),
        (
            &format!("{level}/fields/velocity/0"),
            json!([null, 1]),
            "invalid type",
        ),
    ] {
        let mut bad = good.clone();
        *bad.pointer_mut(place).expect(place) = value;
        bad.as_object_mut().unwrap().remove("checksum");
        std::fs::write(folder.path().join(checkpoint::FILE), sealed(&bad).unwrap()).unwrap();
        let error = run(parsed(RELEASED), folder.path(), true, &mut (), &mut ()).unwrap_err();
        assert!(matches!(error, SwimError::Checkpoint { .. }), "{error:?}");
        let message = error.to_string();
        assert!(message.contains(fragment), "{place}: {message}");
        assert!(message.contains("without --resume"), "{message}");
    }
}
