//! Output of the command: exit codes, one line per error, complete files.

use std::path::Path;
use std::process::Output;

use testkit::{SceneText, contains, pair, within};

use crate::text;

/// Runs the command in the folder of this crate.
fn swim(arguments: &[&str]) -> Output {
    crate::swim(Path::new(env!("CARGO_MANIFEST_DIR")), arguments)
}

fn stderr(output: &Output) -> String {
    text(&output.stderr)
}

/// A file with a scene and the folder of its results, in a temporary folder.
struct Files {
    folder: tempfile::TempDir,
    scene: String,
    out: std::path::PathBuf,
}

impl Files {
    /// `toml` are further lines of the scene.
    fn new(text: &SceneText, toml: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let [scene, out] = ["scene.toml", "out"].map(|name| folder.path().join(name));
        std::fs::write(&scene, format!("{toml}\n{}", text.toml())).unwrap();
        let scene = scene.display().to_string();
        Self { folder, scene, out }
    }

    /// Runs the scene, with its results in the folder.
    fn run(&self, more: &[&str]) -> Output {
        let out = self.out.to_str().unwrap();
        swim(&[&["run", &self.scene, "--out", out], more].concat())
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.out.join(name)).unwrap()
    }
}

const SPHERE: &str = "../../scenes/sphere-in-ball.toml";
const SWIMMER: &str = "../../scenes/three-sphere.toml";

#[test]
fn bad_input_gives_one_line_and_exit_code_2() {
    let cylinder = "use model.kind = \"fem\", or the domain unbounded, ball or wall";
    // Arguments, settings, and what the message contains; names of scenes are in their folder.
    let rows = [
        ("check no-such.toml", &[][..], "cannot read no-such.toml"),
        ("check Cargo.toml", &[], "unknown key"),
        ("run SPHERE", &[], "no [[gait.phases]] to run"),
        (
            "run SWIMMER --resume",
            &[],
            "checkpoint.json does not exist: no run",
        ),
        (
            "sweep SWIMMER --vary fluid.viscosity=1,2 --resume",
            &[],
            "sweep.json: does not exist: no sweep has begun",
        ),
        (
            "check SWIMMER",
            &["links.left-arm.length=8"],
            "bodies.centre.position, gait.phases.0.length, gait.phases.2.length",
        ),
        (
            "map SWIMMER",
            &["optimise.lower=9", "optimise.upper=8"],
            "no value of \"left-arm\" is allowed",
        ),
        (
            "run SWIMMER --out Cargo.toml/out",
            &[],
            "cannot write Cargo.toml/out",
        ),
        ("run SWIMMER", &["domain.radius=10.5"], "outside the domain"),
        (
            "solve SWIMMER",
            &["fluid.viscosity=0"],
            "--set fluid.viscosity=0: fluid.viscosity must be",
        ),
        (
            "solve SWIMMER --json",
            &["model.kind=axisymmetric", "bodies.left.torque=[0, 0, 1]"],
            "not supported",
        ),
        (
            "check SWIMMER",
            &["domain.kind=cylinder", "model.kind=rpy"],
            cylinder,
        ),
        ("mesh SPHERE --out mesh.stl", &[], ".vtu"),
    ];
    for (line, settings, fragment) in rows {
        let line = line.replace("SPHERE", SPHERE).replace("SWIMMER", SWIMMER);
        let mut arguments: Vec<&str> = line.split(' ').collect();
        arguments.extend(settings.iter().flat_map(|setting| ["--set", setting]));
        let output = swim(&arguments);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        contains(&arguments, &message, &["error: ", fragment]);
        assert!(message.starts_with("error: "), "{message}");
        assert_eq!(message.trim_end().lines().count(), 1, "{message}");
        assert!(output.stdout.is_empty());
    }
    // Nothing was made for what was refused.
    assert!(!Path::new(env!("CARGO_MANIFEST_DIR")).join("out").exists());
}

/// Mistakes with a Gmsh mesh are those of the scene, and name what the mesh does not have.
#[test]
fn bug_a_wrong_name_of_a_wall_counted_as_a_failed_method() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let mesh = at("ball.msh");
    let sizes = ["--set", "fem.surface_size=0.9"];
    let made = swim(&[&["mesh", SPHERE, "--out", &mesh][..], &sizes].concat());
    assert!(made.status.success(), "{}", stderr(&made));
    let surface = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/cell-1.obj");
    std::fs::copy(surface, at("cell.obj")).unwrap();
    for (file, wall, surface, parts) in [
        (
            "ball.msh",
            "wall",
            "sphere",
            ["'outer' is neither", "the mesh has no part 'wall'"],
        ),
        (
            "ball.msh",
            "outer",
            "ball",
            ["'sphere' is neither", "the mesh has no part 'ball'"],
        ),
        (
            "cell.obj",
            "outer",
            "sphere",
            ["$Nodes, found 'v", "this is no mesh of Gmsh"],
        ),
    ] {
        let text = format!(
            "domain = {{ kind = \"mesh\", file = \"{file}\", walls = [\"{wall}\"] }}\n\
             bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0], \
             surface = \"{surface}\", force = [1, 0, 0] }}]\n"
        );
        std::fs::write(at("mine.toml"), text).unwrap();
        let output = swim(&["solve", &at("mine.toml")]);
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        contains([file, wall, surface], &stderr(&output), &parts);
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
    contains(
        "help",
        &text(&help.stdout),
        &["run", "solve", "check", "mesh"],
    );
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
    let [exact, _] = testkit::exact::concentric_mobility(0.1);
    let speed = body["velocity"][0].as_f64().unwrap();
    within(speed / exact - 1.0, 0.02, "the default mesh is much better");
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
    let keys =
        "domain = { kind = \"ball\", radius = 12 }\nmodel = { kind = \"fem\", tolerance = 0.1 }";
    let files = Files::new(&pair(-2.0, 2.0).phases(&[("arm", 4.5)]), keys);
    let output = files.run(&[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let text = text(&output.stdout);
    let mut lines = text.lines();
    let net = lines
        .find(|line| line.starts_with("net displacement  "))
        .unwrap();
    // The displacement is zero up to its error bar, so no ratio is printed.
    assert!(net.contains(" +- ") && !net.contains('%'), "{net}");
    assert!(!text.contains("warning"), "warnings go to stderr: {text}");
    let names: Vec<String> = std::fs::read_dir(&files.out)
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
    let read = |name: &str| files.read(name);
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).unwrap();
    for key in "displacement rotation phases solves error_estimate seconds".split(' ') {
        assert!(summary.get(key).is_some(), "{key}");
    }
    assert_eq!(summary["phases"][0]["link"], "arm");
    assert_eq!(
        summary["phases"][0]["displacement"],
        summary["displacement"]
    );
    // The arm extends by 0.5, and by symmetry each body moves by half of it.
    let moved = |body: &str| summary["displacement"][body][0].as_f64().unwrap();
    // The noise of the mesh rotates the pair by about 1e-5, which shortens the projection of an arm
    // of 4.5 by 4.5 (1e-5)^2 / 2 = 2e-10.
    within(moved("b") - moved("a") - 0.5, 1e-8, "fifty times that");
    within(
        moved("b") - 0.25,
        1e-3,
        "the noise of the default mesh is well below",
    );
    let csv = read("trajectory.csv");
    let rows: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(
        rows[0][..6],
        ["time", "cycle", "phase", "arm.length", "a.x", "a.y"]
    );
    assert!(rows.iter().all(|row| row.len() == 4 + 2 * 18 + 1));
    assert!(rows.iter().flatten().all(|cell| !cell.is_empty()));
    let last = rows.last().unwrap();
    assert_eq!((last[0], last[3]), ("1", "4.5"));
    let end = last[4].parse::<f64>().unwrap();
    within(
        end + 2.0 - moved("a"),
        1e-15,
        "one unit in the last place of the sum",
    );
    // The flow files are exactly those that the collection names.
    let pvd = read("trajectory.pvd");
    let flows: Vec<&String> = names.iter().filter(|name| name.ends_with(".vtu")).collect();
    assert!(!flows.is_empty() && flows.iter().all(|flow| pvd.contains(&***flow)));
    assert_eq!(pvd.matches("<DataSet").count(), flows.len());
    // One flow per phase, unless others are requested.
    assert_eq!(flows.len(), 1);
    let run = |which: &str| {
        let out = files.folder.path().join(which);
        let (key, to) = (format!("fem.flows={which}"), out.to_str().unwrap());
        let arguments = ["run", &files.scene, "--set", &key, "--out", to];
        assert!(swim(&arguments).status.success());
        let names = std::fs::read_dir(out).unwrap();
        let names = names.map(|entry| entry.unwrap().file_name().into_string().unwrap());
        names.filter(|name| name.ends_with(".vtu")).count()
    };
    assert_eq!(run("off"), 0);
    // All points of the integration that are rows of the trajectory.
    let solved = rows.iter().filter(|row| row.last() == Some(&"1"));
    assert_eq!(run("all"), solved.count());
    assert!(read("trajectory.svg").trim_end().ends_with("</svg>"));
}

/// Tables have no flows, and `Tabulated` did not forward those of the model.
#[test]
fn bug_tabulated_swimmers_by_elements_wrote_no_flows() {
    let keys = "model = { kind = \"fem\", tolerance = 0.3 }\ngait.cycles = 3\n\
                fem = { size_factor = 2.5, estimates = \"off\", flows = \"all\" }";
    let text = SceneText::new()
        .sphere("a", 1.0, [-2, 0, 0])
        .sphere("b", 1.5, [3, 0, 0]);
    let text = text
        .slide("arm", "b", "a")
        .phases(&[("arm", 5.5), ("arm", 5.0)]);
    let files = Files::new(&text, keys);
    let output = files.run(&[]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let read = |name: &str| files.read(name);
    assert!(read("summary.json").contains("tabulated over the shapes"));
    let csv = read("trajectory.csv");
    let solved = csv.lines().filter(|row| row.ends_with(",1"));
    let pvd = read("trajectory.pvd");
    assert!(solved.clone().count() >= 3 * 2);
    assert_eq!(pvd.matches("<DataSet").count(), solved.count());
    for file in pvd.split('"').filter(|text| text.ends_with(".vtu")) {
        assert!(
            files.out.join(file).metadata().unwrap().len() > 1000,
            "{file}"
        );
    }
}

#[test]
fn a_collision_names_bodies_and_time_and_the_completed_phases_are_kept() {
    // A stone is pulled towards a swimmer at rest, along its axis, where the expansions that
    // estimate the error of the model near contact are cheap. By Stokes' law it covers the distance
    // of six radii in at least 6 * 6 pi / 40 = 2.8 units of time, so the first phases are completed
    // and a later one ends the run.
    let keys = "model = { kind = \"rpy\", tolerance = 1e-2 }\ngait.cycles = 20";
    let text = SceneText::new()
        .sphere("a", 1.0, [-8, 0, 0])
        .sphere("b", 1.0, [0, 0, 0])
        .shape("stone", "radius = 1, force = [-40, 0, 0]", [8, 0, 0])
        .slide("arm", "b", "a")
        .phase("duration = 1");
    let files = Files::new(&text, keys);
    // The summary of an older run must not be taken for the result of this one.
    std::fs::create_dir(&files.out).unwrap();
    std::fs::write(files.out.join("summary.json"), "{}").unwrap();
    let first = files.run(&[]);
    let message = stderr(&first);
    assert_eq!(first.status.code(), Some(3), "{message}");
    let mut lines = message.lines();
    let error = lines.find(|line| line.starts_with("error: ")).unwrap();
    contains(
        "collision",
        error,
        &["'b'", "'stone'", "touch", "time ", "phase "],
    );
    let number = |after: &str| -> f64 {
        let rest = error.split_once(after).unwrap().1;
        let end = rest.find([' ', ')']).unwrap();
        rest[..end].parse().unwrap()
    };
    let (phase, time) = (number("phase "), number("time "));
    assert!(phase > 1.0 && time > phase - 1.0 && time < phase, "{error}");
    let percent = number("constant lengths, ");
    let why = "the percentage is that of the phase, with one decimal";
    within(time - (phase - 1.0) - 0.01 * percent, 6e-4, why);
    // The trajectory ends at the contact, the checkpoint with the last complete phase.
    let read = |name: &str| files.read(name);
    let csv = read("trajectory.csv");
    let last = csv.lines().last().unwrap().split(',').next().unwrap();
    let why = "the message has four decimals";
    within(last.parse::<f64>().unwrap() - time, 5.1e-5, why);
    assert!(read("trajectory.svg").trim_end().ends_with("</svg>"));
    let checkpoint: serde_json::Value = serde_json::from_str(&read("checkpoint.json")).unwrap();
    let spans = checkpoint["outcome"]["spans"].as_array().unwrap();
    assert_eq!(spans.len() as f64, phase - 1.0);
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).unwrap();
    let contact = summary["stopped"].as_str().unwrap();
    contains("contact", contact, &["'b'", "'stone'"]);
    // The results up to there are printed, and the page has them; `swim view` writes it again.
    let printed = String::from_utf8_lossy(&first.stdout);
    contains(
        "printed",
        &printed,
        &["net displacement", "stopped", "of 20"],
    );
    let page = read("report.html");
    contains("page", &page, &["Stopped before its end", "'stone' touch"]);
    let numbers = page.split_once("id=\"run-data\">").unwrap().1;
    let numbers = numbers.split_once("</script>").unwrap().0;
    let numbers: serde_json::Value = serde_json::from_str(numbers).unwrap();
    assert!(!numbers["slices"].as_array().unwrap().is_empty());
    std::fs::remove_file(files.out.join("report.html")).unwrap();
    let viewed = swim(&["view", files.out.to_str().unwrap()]);
    assert_eq!(viewed.status.code(), Some(0), "{}", stderr(&viewed));
    assert!(read("report.html") == page);
    // A resumed run ends with the same error.
    let again = files.run(&["--resume"]);
    assert_eq!(again.status.code(), Some(3));
    assert!(stderr(&again).contains(error));
}

#[test]
fn check_prints_the_model_and_its_cost() {
    let output = swim(&["check", SPHERE]);
    assert_eq!(output.status.code(), Some(0), "{}", stderr(&output));
    let model = "model                   fem";
    let parts = [model, "degrees of freedom", "MiB", "axisymmetric"];
    contains("check", &text(&output.stdout), &parts);
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
    contains("warning", &message, &["the estimate is", " %", "reduce"]);
}

/// A sphere in the shear `u = (y, 0, 0)` stays and turns by half the vorticity, `-t / 2` about z.
#[test]
fn the_picture_of_bodies_that_only_turn_shows_their_rotation() {
    let flow = "background = { kind = \"shear\", gradient = [[0, 1, 0], [0, 0, 0], [0, 0, 0]] }";
    let text = SceneText::new()
        .sphere("ball", 1.0, [0; 3])
        .phase("duration = 8");
    let files = Files::new(&text, flow);
    let run = files.run(&[]);
    assert!(run.status.success(), "{}", stderr(&run));
    let parts = [
        "rotation of the bodies about z",
        "ball -4.00000",
        "time 1.6906",
    ];
    contains("picture", &files.read("trajectory.svg"), &parts);
}

/// 343 spheres in a cubic lattice at gaps of 0.0012 need orders of two hundred.
#[test]
fn expansions_that_do_not_fit_into_memory_are_refused_with_memory_and_time() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = String::from("model = { kind = \"multipole\", tolerance = 1e-3 }\n");
    for k in 0..343 {
        let [x, y, z] = [k % 7, k / 7 % 7, k / 49].map(|cell| 2.0012 * f64::from(cell));
        scene += &format!(
            "[[bodies]]\nname = \"b{k}\"\nradius = 1\nposition = [{x}, {y}, {z}]\n\
             force = [0, 0, 1]\n"
        );
    }
    std::fs::write(folder.path().join("lattice.toml"), scene).unwrap();
    let output = crate::swim(folder.path(), &["solve", "lattice.toml"]);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{message}");
    let (of_memory, of_time) = message.split_once(" MiB and ").expect(&message);
    let mib: f64 = of_memory.rsplit(' ').next().unwrap().parse().unwrap();
    let (seconds, _) = of_time.split_once(" s on two cores").expect(&message);
    let seconds: f64 = seconds.parse().unwrap();
    assert!(mib > 6144.0 && seconds > 0.0, "{message}");
}
