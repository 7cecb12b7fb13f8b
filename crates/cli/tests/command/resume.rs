//! Interrupted runs continue with bitwise the same results.
#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::Value;
use swimmer::checkpoint::FILE;

/// Two unequal spheres in a small ball; the long stroke needs a new mesh on the way.
const SCENE: &str = r#"
    domain = { kind = "ball", radius = 9 }
    model = { kind = "fem", tolerance = 1e-2 }
    fem.surface_size = 1.2
    gait.cycles = 2
    [[bodies]]
    name = "a"
    radius = 1
    position = [-4.5, 0, 0.2]
    [[bodies]]
    name = "b"
    radius = 1.5
    position = [3, 0, 0]
    [[links]]
    name = "arm"
    body = "a"
    to = "b"
    [[gait.phases]]
    link = "arm"
    length = 3
    [[gait.phases]]
    link = "arm"
    length = 7.5
"#;

fn start(folder: &Path, out: &str, more: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_swim"))
        .args(["run", "scene.toml", "--out", out])
        .args(more)
        .current_dir(folder)
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

/// The results of a run without time and memory.
fn results(out: &Path) -> (Value, Vec<u8>) {
    let text = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let mut summary: Value = serde_json::from_str(&text).unwrap();
    for key in ["seconds", "peak_rss_mib"] {
        summary.as_object_mut().unwrap().remove(key);
    }
    (summary, std::fs::read(out.join("trajectory.csv")).unwrap())
}

/// Number of completed phases in the checkpoint; none without a checkpoint.
fn phases_done(out: &Path) -> Option<usize> {
    let text = std::fs::read_to_string(out.join(FILE)).ok()?;
    let checkpoint: Value = serde_json::from_str(&text).unwrap();
    Some(checkpoint["outcome"]["spans"].as_array().unwrap().len())
}

/// Sends a signal to a run when it has completed a number of phases.
fn signal_after(child: &mut Child, out: &Path, phases: usize, signal: &str) {
    while phases_done(out).is_none_or(|done| done < phases) {
        assert!(child.try_wait().unwrap().is_none(), "the run ended early");
        std::thread::sleep(Duration::from_millis(5));
    }
    let status = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status()
        .unwrap();
    assert!(status.success());
}

#[test]
fn killed_and_interrupted_runs_end_like_an_uninterrupted_one() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    std::fs::write(folder.join("scene.toml"), SCENE).unwrap();
    assert!(start(folder, "whole", &[]).wait().unwrap().success());

    let out = folder.join("broken");
    let mut killed = start(folder, "broken", &[]);
    signal_after(&mut killed, &out, 1, "-KILL");
    assert!(!killed.wait().unwrap().success());
    // As if it had been killed between the slices of the flow and their checkpoint, and while it
    // wrote a file.
    let slices = |out: &Path| std::fs::read(out.join("flow_slices.json")).unwrap();
    std::fs::write(out.join("flow_slices.json"), slices(&folder.join("whole"))).unwrap();
    std::fs::write(out.join(".trajectory.csvAb12cD.tmp"), "half").unwrap();

    let mut interrupted = start(folder, "broken", &["--resume"]);
    signal_after(&mut interrupted, &out, 2, "-INT");
    assert_eq!(interrupted.wait().unwrap().code(), Some(130));
    assert!((2..4).contains(&phases_done(&out).unwrap()));

    let mut resumed = start(folder, "broken", &["--resume"]);
    assert!(resumed.wait().unwrap().success());
    assert_eq!(results(&folder.join("whole")), results(&out));
    let collection = |out: &Path| std::fs::read(out.join("trajectory.pvd")).unwrap();
    assert_eq!(collection(&folder.join("whole")), collection(&out));
    assert_eq!(
        slices(&folder.join("whole")),
        slices(&out),
        "doubled slices"
    );
    let entries = std::fs::read_dir(&out).unwrap();
    let names = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let left: Vec<String> = names
        .filter(|name| name.ends_with(".tmp") || name.ends_with(".lock"))
        .collect();
    assert_eq!(left, [""; 0]);
}

#[test]
fn a_second_run_into_a_folder_is_refused_and_a_hangup_leaves_a_checkpoint() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    std::fs::write(folder.join("scene.toml"), SCENE).unwrap();
    let mut first = start(folder, "out", &[]);
    while phases_done(&folder.join("out")).is_none() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let message = crate::refused(folder, &["run", "scene.toml", "--out", "out"]);
    let process = format!("process {}", first.id());
    testkit::contains("lock", &message, &[&process, "--out"]);
    signal_after(&mut first, &folder.join("out"), 0, "-HUP");
    assert_eq!(first.wait().unwrap().code(), Some(130));
}

#[test]
fn a_checkpoint_of_another_scene_is_refused_with_the_difference() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    std::fs::write(folder.join("scene.toml"), SCENE).unwrap();
    let mut run = start(folder, "out", &[]);
    signal_after(&mut run, &folder.join("out"), 0, "-TERM");
    assert!(run.wait().is_ok());
    let other = ["--set", "domain.radius=10"];
    let arguments = [
        &["run", "scene.toml", "--out", "out", "--resume"][..],
        &other,
    ]
    .concat();
    let message = crate::refused(folder, &arguments);
    testkit::contains("resume", &message, &["another scene", "radius"]);
}
