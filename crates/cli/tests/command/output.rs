//! Output of the command: exit codes, one line per error, complete files.

use std::path::Path;
use std::process::{Command, Output};

fn swim(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_swim"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

const SPHERE: &str = "../../scenes/sphere-in-ball.toml";
const SWIMMER: &str = "../../scenes/three-sphere.toml";

#[test]
fn bad_input_gives_one_line_and_exit_code_2() {
    let file = Path::new("Cargo.toml").display().to_string();
    for (arguments, fragment) in [
        (&["check", "no-such.toml"][..], "cannot read no-such.toml"),
        (&["check", &file], "unknown key"),
        (&["run", SPHERE], "no [[gait.phases]] to run"),
        (&["run", SWIMMER, "--resume"], "checkpoint.json"),
        (
            &["run", SWIMMER, "--out", "Cargo.toml/out"],
            "cannot write Cargo.toml/out",
        ),
        (
            &["run", SWIMMER, "--set", "domain.radius=10.5"],
            "outside the domain",
        ),
        (
            &["solve", SWIMMER, "--set", "fluid.viscosity=0"],
            "--set fluid.viscosity=0: fluid.viscosity must be",
        ),
        (
            &[
                "solve",
                SWIMMER,
                "--json",
                "--set",
                "model.kind=axisymmetric",
                "--set",
                "bodies.left.torque=[0, 0, 1]",
            ],
            "not supported",
        ),
        (
            &[
                "check",
                SWIMMER,
                "--set",
                "domain.kind=cylinder",
                "--set",
                "model.kind=rpy",
            ],
            "use model.kind = \"fem\", or the domain unbounded, ball or wall",
        ),
        (&["mesh", SPHERE, "--out", "mesh.stl"], ".vtu"),
    ] {
        let output = swim(arguments);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(
            message.starts_with("error: ") && message.contains(fragment),
            "{arguments:?}: {message}"
        );
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn wrong_usage_has_exit_code_2_and_help_has_0() {
    for arguments in [
        &["walk"][..],
        &["run"],
        &["mesh", SPHERE],
        &["check", SPHERE, "--set"],
    ] {
        assert_eq!(swim(arguments).status.code(), Some(2), "{arguments:?}");
    }
    let help = swim(&["--help"]);
    assert_eq!(help.status.code(), Some(0));
    let text = String::from_utf8_lossy(&help.stdout).into_owned();
    for command in ["run", "solve", "check", "mesh"] {
        assert!(text.contains(command));
    }
}

#[test]
fn solve_prints_the_documented_json_object() {
    let output = swim(&["solve", SPHERE, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["model"], "fem");
    let body = &answer["bodies"][0];
    assert_eq!(body["name"], "sphere");
    for key in ["velocity", "angular_velocity", "force", "torque"] {
        assert_eq!(body[key].as_array().unwrap().len(), 3, "{key}");
    }
    // Haberman & Sayre: K = 1.2861963385 for a radius of a tenth of the container. The default mesh
    // is much better than 2 %.
    let exact = 1.0 / (6.0 * std::f64::consts::PI * 1.2861963384700);
    let speed = body["velocity"][0].as_f64().unwrap();
    assert!((speed / exact - 1.0).abs() < 0.02, "{speed} {exact}");
    for key in ["velocity", "pressure", "total"] {
        assert!(answer["dofs"][key].as_u64().unwrap() > 0);
    }
    assert_eq!(answer["solver"]["formulation"], "p-tilde");
    assert_eq!(answer["solver"]["solver"], "block");
    assert!(answer["solver"]["iterations"].as_u64().unwrap() > 0);
    assert!(answer["solver"]["true_relative_residual"].as_f64().unwrap() <= 1e-8);
    for key in ["mesh", "assembly", "setup", "solve", "total"] {
        assert!(answer["seconds"][key].as_f64().unwrap() >= 0.0);
    }
    assert!(answer["error_estimate"].is_object() && answer.get("peak_rss_mib").is_some());
}

#[test]
fn a_run_writes_complete_and_consistent_files() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("pair.toml");
    std::fs::write(
        &scene,
        "domain = { kind = \"ball\", radius = 12 }\nmodel = { kind = \"fem\", tolerance = 0.1 }\n\
         bodies = [{ name = \"a\", radius = 1, position = [-2, 0, 0] }, \
         { name = \"b\", radius = 1, position = [2, 0, 0] }]\n\
         links = [{ name = \"arm\", body = \"b\", to = \"a\" }]\n\
         gait.phases = [{ link = \"arm\", length = 4.5 }]\n",
    )
    .unwrap();
    let out = folder.path().join("out");
    let output = swim(&[
        "run",
        scene.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let net = text
        .lines()
        .find(|line| line.starts_with("net displacement  "))
        .unwrap();
    // The displacement is zero up to its error bar, so no ratio is printed.
    assert!(net.contains(" +- ") && !net.contains('%'), "{net}");
    assert!(!text.contains("warning"), "warnings go to stderr: {text}");
    let names: Vec<String> = std::fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    for name in [
        "summary.json",
        "trajectory.csv",
        "trajectory.svg",
        "trajectory.pvd",
    ] {
        assert!(
            names.iter().any(|n| n == name),
            "{name} is not in {names:?}"
        );
    }
    assert!(names.iter().all(|name| !name.starts_with('.')), "{names:?}");
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).unwrap();
    for key in [
        "displacement",
        "rotation",
        "phases",
        "solves",
        "error_estimate",
        "seconds",
    ] {
        assert!(summary.get(key).is_some(), "{key}");
    }
    assert_eq!(summary["phases"][0]["link"], "arm");
    assert_eq!(
        summary["phases"][0]["displacement"],
        summary["displacement"]
    );
    // The arm extends by 0.5, and by symmetry each body moves by half of it. The noise of the
    // default mesh is well below 1e-3.
    let moved = |body: &str| summary["displacement"][body][0].as_f64().unwrap();
    // The noise of the mesh rotates the pair by about 1e-5, which shortens the projection of an arm
    // of 4.5 by 4.5 (1e-5)^2 / 2 = 2e-10.
    assert!((moved("b") - moved("a") - 0.5).abs() < 1e-8);
    assert!((moved("b") - 0.25).abs() < 1e-3, "{}", moved("b"));
    let csv = read("trajectory.csv");
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(
        rows[0][..6],
        ["time", "cycle", "phase", "arm.length", "a.x", "a.y"]
    );
    assert!(rows.iter().all(|row| row.len() == 4 + 2 * 18));
    let last = rows.last().unwrap();
    assert_eq!((last[0], last[3]), ("1", "4.5"));
    // The sum has a rounding error of one unit in the last place.
    assert!((last[4].parse::<f64>().unwrap() + 2.0 - moved("a")).abs() < 1e-15);
    // The flow files are exactly those that the collection names.
    let pvd = read("trajectory.pvd");
    let flows: Vec<&String> = names.iter().filter(|name| name.ends_with(".vtu")).collect();
    assert!(!flows.is_empty() && flows.iter().all(|flow| pvd.contains(&***flow)));
    assert_eq!(pvd.matches("<DataSet").count(), flows.len());
    // One flow per phase, unless others are requested.
    assert_eq!(flows.len(), 1);
    let run = |which: &str| {
        let out = folder.path().join(which);
        let key = format!("fem.flows={which}");
        let arguments = [
            "run",
            scene.to_str().unwrap(),
            "--set",
            &key,
            "--out",
            out.to_str().unwrap(),
        ];
        assert!(swim(&arguments).status.success());
        let names = std::fs::read_dir(out).unwrap();
        let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.ends_with(".vtu")).count()
    };
    assert_eq!(run("off"), 0);
    // All points of the integration that are rows of the trajectory with velocities.
    assert_eq!(
        run("all"),
        rows.iter().filter(|row| !row[10].is_empty()).count() - 1
    );
    assert!(read("trajectory.svg").trim_end().ends_with("</svg>"));
}

/// Tables have no flows, and `Tabulated` did not forward those of the model.
#[test]
fn bug_tabulated_swimmers_by_elements_wrote_no_flows() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("pair.toml");
    std::fs::write(
        &scene,
        "model = { kind = \"fem\", tolerance = 0.3 }\n\
         fem = { size_factor = 2.5, estimates = \"off\", flows = \"all\" }\n\
         bodies = [{ name = \"a\", radius = 1, position = [-2, 0, 0] }, \
         { name = \"b\", radius = 1.5, position = [3, 0, 0] }]\n\
         links = [{ name = \"arm\", body = \"b\", to = \"a\" }]\n\
         gait = { cycles = 3, phases = [{ link = \"arm\", length = 5.5 }, \
         { link = \"arm\", length = 5 }] }\n",
    )
    .unwrap();
    let out = folder.path().join("out");
    let (scene, to) = (scene.to_str().unwrap(), out.to_str().unwrap());
    let output = swim(&["run", scene, "--out", to]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    assert!(read("summary.json").contains("tabulated over the shapes"));
    let csv = read("trajectory.csv");
    let solved = csv
        .lines()
        .skip(1)
        .filter(|row| row.split(',').nth(10) != Some(""));
    let pvd = read("trajectory.pvd");
    assert!(solved.clone().count() >= 3 * 2);
    assert_eq!(pvd.matches("<DataSet").count(), solved.count());
    for file in pvd.split('"').filter(|text| text.ends_with(".vtu")) {
        assert!(out.join(file).metadata().unwrap().len() > 1000, "{file}");
    }
}

#[test]
fn a_collision_names_bodies_and_time_and_the_completed_phases_are_kept() {
    // A stone is pulled towards a swimmer at rest. By Stokes' law it covers the distance of six
    // radii in at least 6 * 6 pi / 40 = 2.8 units of time, so the first phases are completed and a
    // later one ends the run.
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("falling.toml");
    std::fs::write(
        &scene,
        "model = { kind = \"rpy\", tolerance = 1e-2 }\n\
         bodies = [{ name = \"a\", radius = 1, position = [0, -4, 0] }, \
         { name = \"b\", radius = 1, position = [0, 4, 0] }, \
         { name = \"stone\", radius = 1, position = [8, 4, 0], force = [-40, 0, 0] }]\n\
         links = [{ name = \"arm\", body = \"b\", to = \"a\" }]\n\
         gait = { cycles = 20, phases = [{ duration = 1 }] }\n",
    )
    .unwrap();
    let out = folder.path().join("out");
    // The summary of an older run must not be taken for the result of this one.
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("summary.json"), "{}").unwrap();
    let arguments = [
        "run",
        scene.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ];
    let first = swim(&arguments);
    let message = stderr(&first);
    assert_eq!(first.status.code(), Some(3), "{message}");
    let error = message
        .lines()
        .find(|line| line.starts_with("error: "))
        .unwrap();
    for part in ["'b'", "'stone'", "touch", "time ", "phase "] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let number = |after: &str| -> f64 {
        let rest = error.split_once(after).unwrap().1;
        let end = rest.find([' ', ')']).unwrap();
        rest[..end].parse().unwrap()
    };
    let (phase, time) = (number("phase "), number("time "));
    assert!(phase > 1.0 && time > phase - 1.0 && time < phase, "{error}");
    // The percentage is that of the phase, with one decimal.
    let percent = number("constant lengths, ");
    assert!(
        (time - (phase - 1.0) - 0.01 * percent).abs() < 6e-4,
        "{error}"
    );
    // All earlier phases are complete in the trajectory and in the checkpoint.
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let csv = read("trajectory.csv");
    let last = csv.lines().last().unwrap().split(',').next().unwrap();
    assert_eq!(last.parse::<f64>().unwrap(), phase - 1.0);
    assert!(read("trajectory.svg").trim_end().ends_with("</svg>"));
    let checkpoint: serde_json::Value = serde_json::from_str(&read("checkpoint.json")).unwrap();
    let spans = checkpoint["outcome"]["spans"].as_array().unwrap();
    assert_eq!(spans.len() as f64, phase - 1.0);
    // There is no summary, and a resumed run ends with the same error.
    assert!(!out.join("summary.json").exists());
    let again = swim(&[&arguments[..], &["--resume"]].concat());
    assert_eq!(again.status.code(), Some(3));
    assert!(stderr(&again).contains(error));
}

#[test]
fn check_prints_the_model_and_its_cost() {
    let output = swim(&["check", SPHERE]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for fragment in [
        "model                   fem",
        "degrees of freedom",
        "MiB",
        "axisymmetric",
    ] {
        assert!(text.contains(fragment), "{fragment}: {text}");
    }
}

#[test]
fn mesh_writes_the_mesh_and_prints_its_quality() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mesh.vtu");
    let output = swim(&["mesh", SPHERE, "--out", file.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(String::from_utf8_lossy(&output.stdout).contains("dihedral"));
    assert!(std::fs::read(file).unwrap().starts_with(b"<?xml"));
}

#[test]
fn new_writes_a_valid_scene() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.toml");
    let file = file.to_str().unwrap();
    for name in ["purcell", "scallop", "elastic-arm", "corkscrew", "planar"] {
        let output = swim(&["new", name, "--out", file]);
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(swim(&["check", file]).status.success(), "{name}");
        if name != "planar" {
            std::fs::remove_file(file).unwrap();
        }
    }
    // Existing files are not overwritten; for an unknown name the known ones are listed.
    assert_eq!(
        swim(&["new", "planar", "--out", file]).status.code(),
        Some(2)
    );
    let output = swim(&["new", "cubic"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("three-sphere, smooth, chain, planar, tetrahedral"));
}

#[test]
fn a_missed_target_is_a_warning_on_stderr() {
    let settings = ["fem.target=1e-7", "fem.size_factor=2"];
    let output = swim(&["solve", SPHERE, "--set", settings[0], "--set", settings[1]]);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(0), "{message}");
    assert!(
        message.starts_with("warning: fem.target = 1e-7 allows"),
        "{message}"
    );
    for part in ["the estimate is", " %", "reduce"] {
        assert!(message.contains(part), "{part}: {message}");
    }
}

/// A sphere in the shear `u = (y, 0, 0)` stays and turns by half the vorticity, `-t / 2` about z.
#[test]
fn the_picture_of_bodies_that_only_turn_shows_their_rotation() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("shear.toml");
    let text = "background = { kind = \"shear\", gradient = [[0, 1, 0], [0, 0, 0], [0, 0, 0]] }\n\
                bodies = [{ name = \"ball\", radius = 1, position = [0, 0, 0] }]\n\
                gait.phases = [{ duration = 8 }]\n";
    std::fs::write(&scene, text).unwrap();
    let out = folder.path().join("out");
    let run = swim(&[
        "run",
        scene.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ]);
    assert!(run.status.success(), "{}", stderr(&run));
    let svg = std::fs::read_to_string(out.join("trajectory.svg")).unwrap();
    for text in [
        "rotation of the bodies about z",
        "ball -4.00000",
        "time 1.6906",
    ] {
        assert!(svg.contains(text), "{text}");
    }
}
