//! Full disks, absurd environments and damaged files: one line per error, and no number is lost.
#![cfg(target_os = "linux")]

use std::path::Path;

use testkit::contains;

use crate::{printed, refused, shell, text};

const SWIMMER: &str = include_str!("../../../../scenes/three-sphere.toml");

/// A folder with the three-sphere swimmer in unbounded fluid.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let text = SWIMMER.replace("kind = \"ball\"\nradius = 40", "kind = \"unbounded\"");
    assert_ne!(text, SWIMMER);
    let text = text.replace("\"fem\"", "\"rpy\"");
    std::fs::write(folder.path().join("scene.toml"), text).unwrap();
    folder
}

/// Output and message of a line of the shell that ends with the code 2.
fn failed(folder: &Path, line: &str) -> (String, String) {
    let output = shell(folder, line);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}: {message}");
    (text(&output.stdout), message)
}

#[test]
fn a_result_that_cannot_be_written_is_an_error() {
    let folder = folder();
    for command in [
        "solve scene.toml --json",
        "-q run scene.toml --json",
        "check scene.toml",
        "--help",
        "--version",
    ] {
        let line = format!("swim {command} > /dev/full");
        let (_, message) = failed(folder.path(), &line);
        contains(&line, &message, &["standard output: No space left"]);
    }
    // A reader that has seen enough is no error.
    let line = "(swim check scene.toml; echo $? >&2) | true";
    contains(line, &text(&shell(folder.path(), line).stderr), &["0"]);
}

/// The flow replaced the file into which the shell had put the output, which was lost.
#[test]
fn bug_a_flow_on_standard_output_lost_the_numbers() {
    let folder = folder();
    let line = "swim solve scene.toml --flow /dev/stdout > both";
    let output = shell(folder.path(), line);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let both = std::fs::read(folder.path().join("both")).unwrap();
    contains(
        line,
        &text(&both),
        &["VTKFile", "velocity", "power on the fluid"],
    );
}

#[test]
fn a_failed_picture_keeps_the_numbers_and_leaves_no_half_of_a_file() {
    let folder = folder();
    let line = "ulimit -f 8; swim solve scene.toml --picture flow.svg";
    let (numbers, message) = failed(folder.path(), line);
    contains(line, &message, &["cannot write flow.svg: File too large"]);
    contains(line, &numbers, &["velocity", "power on the fluid"]);
    let line = "swim solve scene.toml --json --picture none/flow.svg";
    let (numbers, _) = failed(folder.path(), line);
    let numbers: serde_json::Value = serde_json::from_str(&numbers).unwrap();
    assert_eq!(numbers["bodies"].as_array().unwrap().len(), 3);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_million_threads_are_refused_before_they_start() {
    let line = "RAYON_NUM_THREADS=1000000 swim solve scene.toml";
    let (_, message) = failed(folder().path(), line);
    contains(
        line,
        &message,
        &["RAYON_NUM_THREADS", "1000000", "limit of"],
    );
}

#[test]
fn names_cannot_command_the_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let scene = "bodies = [{ name = \"a\\u001b[31mb\", radius = 1, position = [0, 0, 0] }]";
    std::fs::write(folder.path().join("scene.toml"), scene).unwrap();
    for arguments in [
        &["solve", "scene.toml"][..],
        &["solve", "scene.toml", "--json"],
    ] {
        let text = printed(folder.path(), arguments);
        contains(arguments, &text, &["a\\u001b[31mb"]);
    }
    let other = "bodies.x.radius=2";
    let message = refused(folder.path(), &["solve", "scene.toml", "--set", other]);
    contains("message", &message, &["there are a\\u001b[31mb"]);
}

#[test]
fn results_of_a_scene_named_by_dots_are_below_the_folder_out() {
    let folder = folder();
    let [from, to] = ["scene.toml", "...toml"].map(|name| folder.path().join(name));
    std::fs::rename(from, to).unwrap();
    printed(folder.path(), &["run", "...toml"]);
    assert!(folder.path().join("out/scene/summary.json").exists());
}

/// Grids of a billion columns, and coefficients that end early, were taken as they are.
#[test]
fn damaged_files_of_the_program_are_noticed() {
    let folder = folder();
    let at = |name: &str| folder.path().join("out").join(name);
    printed(folder.path(), &["run", "scene.toml", "--out", "out"]);
    let slices = std::fs::read_to_string(at("flow_slices.json")).unwrap();
    let begin = slices.find("\"columns\":").unwrap() + "\"columns\":".len();
    let end = begin + slices[begin..].find(',').unwrap();
    let huge = format!("{}1000000000{}", &slices[..begin], &slices[end..]);
    std::fs::write(at("flow_slices.json"), huge).unwrap();
    let message = refused(folder.path(), &["view", "out", "--movie"]);
    contains("view", &message, &["flow_slices.json is damaged"]);
    // The page is written without the flow, and the reason is printed.
    let words = printed(folder.path(), &["view", "out"]);
    contains("view", &words, &["report", "flow_slices.json is damaged"]);

    let map = ["map", "scene.toml", "--out", "out", "--json"];
    let first = printed(folder.path(), &map);
    let table = std::fs::read_to_string(at("table.json")).unwrap();
    let number = table.rfind(",0.").or(table.rfind(",-0.")).unwrap();
    let next = number + 1 + table[number + 1..].find([',', ']']).unwrap();
    let cut = format!("{}{}", &table[..number], &table[next..]);
    std::fs::write(at("table.json"), cut).unwrap();
    assert_eq!(printed(folder.path(), &map), first);
    assert_eq!(std::fs::read_to_string(at("table.json")).unwrap(), table);
}
