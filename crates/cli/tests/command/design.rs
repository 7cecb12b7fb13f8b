//! `swim map`, `swim optimise`, `swim learn` and `swim run --sensitivities` as a user meets them.

use std::path::Path;
use std::process::Command;

use serde_json::Value;
use testkit::contains;
use testkit::exact::STROKE;

use crate::{printed, refused, swim, text};

/// A folder with a template as `scene.toml`.
fn template(name: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    printed(folder.path(), &["new", name, "--out", "scene.toml"]);
    folder
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    serde_json::from_str(&printed(folder, arguments)).unwrap()
}

/// Settings that make a search quick.
const QUICK: [&str; 4] = [
    "--set",
    "optimise.terms=8",
    "--set",
    "optimise.tolerance=1e-2",
];

#[test]
fn the_template_is_mapped_optimised_and_run() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let next = printed(folder, &["new", "optimal-stroke"]);
    assert!(next.contains("swim optimise optimal-stroke.toml"), "{next}");

    let map = ["map", "optimal-stroke.toml", "--out", "map", "--json"];
    let map = json(folder, &map);
    assert_eq!(map["links"], serde_json::json!(["left-arm", "right-arm"]));
    // The square of the gait, exact.
    let gait = map["gait"]["displacement"][0].as_f64().unwrap();
    STROKE.check(gait.abs(), 1e-6, "the tolerance of the table");
    let again = printed(folder, &["map", "optimal-stroke.toml", "--out", "map"]);
    assert!(again.contains("of them read from the folder"), "{again}");
    assert!(folder.join("map/map.svg").exists());

    let mut arguments = vec!["optimise", "optimal-stroke.toml", "--out", "best"];
    arguments.extend(QUICK);
    let output = swim(folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("warning: the optimum touches the limits"));
    let found = std::fs::read_to_string(folder.join("best/optimum.json")).unwrap();
    let found: Value = serde_json::from_str(&found).unwrap();
    let efficiency = found["efficiency"].as_f64().unwrap();
    let product = map["gait"]["period_energy_product"].as_f64().unwrap();
    let of_square = 18.0 * std::f64::consts::PI * gait * gait / product;
    assert!(efficiency > 1.2 * of_square, "{efficiency} {of_square}");
    let run = json(folder, &["solve", "best/optimum.toml", "--json"]);
    assert_eq!(run["bodies"].as_array().unwrap().len(), 3);
}

#[test]
fn the_best_cycle_of_the_template_is_learned() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let next = printed(folder, &["new", "learning"]);
    assert!(next.contains("swim learn learning.toml"), "{next}");
    let learned = json(folder, &["learn", "learning.toml", "--json"]);
    assert_eq!(learned["is_optimal"], true);
    let per_step = learned["optimum"]["per_step"].as_f64().unwrap();
    assert!((per_step - 0.064_539_809_4).abs() < 1e-5, "{per_step}");
    let wave = serde_json::json!(["000", "100", "110", "111", "011", "001"]);
    assert_eq!(learned["policy"], wave);
}

#[test]
fn the_best_sizes_are_printed_and_run() {
    let temporary = template("three-sphere");
    let folder = temporary.path();
    let limits = ["--set", "optimise.arms=[4.5, 20]"];
    let arguments = [&["sizes", "scene.toml", "--out", "best"][..], &limits].concat();
    let output = swim(folder, &arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("sizes: 1 runs"));
    let shown = text(&output.stdout);
    let parts = [
        "8.500000, the limit; in the scene 10",
        "is the smallest allowed",
    ];
    contains("sizes", &shown, &parts);
    let found = json(folder, &[&arguments[..], &["--json", "--quiet"]].concat());
    let run = json(folder, &["run", "best/optimum.toml", "--json", "--quiet"]);
    let of_run = run["displacement"]["centre"][0].as_f64().unwrap();
    let of_search = found["best"]["displacement"].as_f64().unwrap();
    assert!((of_run / of_search - 1.0).abs() < 1e-3, "{run}");
    let csv = std::fs::read_to_string(folder.join("best/sizes.csv")).unwrap();
    let runs = found["runs"].as_u64().unwrap();
    assert_eq!(csv.lines().count() as u64, 1 + runs);
    assert!(csv.starts_with("length of left-arm,length of right-arm,objective\n"));
    let message = refused(folder, &["sizes", "scene.toml"]);
    contains("sizes", &message, &["optimise.radii = [0.5, 2]"]);
}

/// The gait of the scene is a table in another folder than the results.
#[test]
fn the_best_sizes_of_a_gait_from_a_file_run() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    std::fs::create_dir(folder.join("scenes")).unwrap();
    let scene = "scenes/scene.toml";
    printed(folder, &["new", "three-sphere", "--out", scene]);
    let square = "time,left-arm,right-arm\n0,10,10\n1,6,10\n2,6,6\n3,10,6\n4,10,10\n";
    std::fs::write(folder.join("scenes/square.csv"), square).unwrap();
    let gait = "gait={ kind = \"table\", file = \"square.csv\", interpolation = \"linear\" }";
    let mut arguments = vec!["sizes", scene, "--out", "results/best", "--json"];
    for setting in [gait, "optimise.radii=[0.9, 1.1]", "optimise.tolerance=1e-2"] {
        arguments.extend(["--set", setting]);
    }
    let found = json(folder, &arguments);
    let run = json(
        folder,
        &["run", "results/best/optimum.toml", "--json", "--quiet"],
    );
    let of_run = run["displacement"]["centre"][0].as_f64().unwrap();
    let of_search = found["best"]["displacement"].as_f64().unwrap();
    assert!((of_run / of_search - 1.0).abs() < 1e-3, "{run}");
    // One line per sphere, with a circle at the best radius.
    let chart = std::fs::read_to_string(folder.join("results/best/sizes.svg")).unwrap();
    assert_eq!(chart.matches("<circle").count(), 3, "{chart}");
}

#[test]
fn scenes_without_a_design_are_refused_with_a_remedy() {
    let temporary = template("optimal-stroke");
    let folder = temporary.path();
    // Command, settings and what the message contains.
    let rows = "
map | bodies.left.force=[1, 0, 0] | without external loads
optimise | bodies.left.force=[1, 0, 0] | without external loads
learn | bodies.left.force=[1, 0, 0] | without external loads
learn | gait.cycles=1 | learn.contracted = 6
optimise | optimise.upper=3 | no value of
optimise | optimise.objective=rotation | optimise.rotation is missing
map | optimise.uper=3 | upper
optimise | optimise.max_rate=-1 | greater than zero, not -1
optimise | optimise.objective=speed | give optimise.max_rate or optimise.max_power
optimise | optimise.max_rate={ left-arm = 1 } | a joint that moves has no largest rate
optimise | optimise.power=1; optimise.max_power=2 | which determine the period
";
    for row in rows.trim().lines() {
        let [command, settings, words] = row.split(" | ").collect::<Vec<_>>()[..] else {
            panic!("{row}");
        };
        let mut arguments = vec![command, "scene.toml", "--out", "out"];
        arguments.extend(settings.split("; ").flat_map(|setting| ["--set", setting]));
        contains(row, &refused(folder, &arguments), &[words]);
    }
}

/// A table of elements that was interrupted continues with its shapes, and is the same to the last
/// digit.
#[cfg(unix)]
#[test]
fn interrupted_tables_of_elements_continue() {
    let temporary = template("three-sphere");
    let folder = temporary.path();
    let arguments = |out: &'static str| {
        let mut arguments = vec!["map", "scene.toml", "--out", out];
        for setting in [
            "domain.kind=ball",
            "domain.radius=20",
            "model.kind=fem",
            "fem.surface_size=1.2",
            "optimise.lower={ left-arm = 6, right-arm = 8 }",
            "optimise.upper={ left-arm = 7, right-arm = 8 }",
        ] {
            arguments.extend(["--set", setting]);
        }
        arguments
    };
    printed(folder, &arguments("whole"));
    let mut interrupted = Command::new(env!("CARGO_BIN_EXE_swim"))
        .args(arguments("broken"))
        .current_dir(folder)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    while !folder.join("broken").exists() {
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    std::thread::sleep(std::time::Duration::from_millis(500));
    let status = Command::new("kill")
        .args(["-INT", &interrupted.id().to_string()])
        .status();
    assert!(status.unwrap().success());
    // A quick machine may be done, a slow one may not have begun to handle signals.
    let code = interrupted.wait().unwrap().code();
    assert!([Some(0), Some(130), None].contains(&code), "{code:?}");
    let partial = folder.join("broken/table.partial.json");
    assert_eq!(partial.exists(), code == Some(130));
    printed(folder, &arguments("broken"));
    assert!(!partial.exists());
    let table = |out: &str| std::fs::read_to_string(folder.join(out).join("table.json")).unwrap();
    assert_eq!(table("whole"), table("broken"));
}

/// Two jobs that share a folder solve a table grid by grid, with the digits of one job.
#[test]
fn the_shares_of_a_map_are_merged() {
    let temporary = template("optimal-stroke");
    let folder = temporary.path();
    let map = |out: &'static str, more: &[&'static str]| {
        let mut arguments = vec!["map", "scene.toml", "--out", out];
        arguments.extend(more);
        arguments
    };
    printed(folder, &map("whole", &[]));
    let mut rounds = 0;
    let merged = loop {
        rounds += 1;
        for share in ["1/2", "2/2"] {
            printed(folder, &map("shared", &["--shard", share]));
        }
        let output = swim(folder, &map("shared", &["--merge"]));
        if output.status.success() {
            break text(&output.stdout);
        }
        assert_eq!(output.status.code(), Some(3));
        let message = text(&output.stderr);
        assert!(message.contains("are missing") && rounds < 5, "{message}");
    };
    assert!(merged.contains("degrees"), "{merged}");
    let table = |out: &str| std::fs::read_to_string(folder.join(out).join("table.json")).unwrap();
    assert_eq!(table("whole"), table("shared"));
    refused(folder, &map("other", &["--shard", "3/2"]));
}

#[test]
fn sensitivities_are_printed_and_written() {
    let temporary = template("three-sphere");
    let folder = temporary.path();
    let arguments = ["run", "scene.toml", "--out", "out", "--sensitivities"];
    let derivative = "derivative of the net displacement by";
    let parts = [derivative, "amplitude of \"right-arm\" = 2"];
    contains("run", &printed(folder, &arguments), &parts);
    let csv = std::fs::read_to_string(folder.join("out/sensitivities.csv")).unwrap();
    assert_eq!(csv.lines().count(), 8, "{csv}");
}

#[test]
fn bug_designs_wrote_into_a_folder_in_which_another_process_writes() {
    let folder = tempfile::tempdir().unwrap();
    swim(folder.path(), &["new", "three-sphere"]);
    let out = swimmer::Folder::create(folder.path().join("out")).unwrap();
    let lock = out.lock().unwrap();
    for command in ["run", "map", "optimise", "learn", "sizes", "frequency"] {
        // Without it there is nothing to learn.
        let contracted = "learn.contracted=6";
        let arguments = [
            command,
            "three-sphere.toml",
            "--out",
            "out",
            "--set",
            contracted,
        ];
        let message = refused(folder.path(), &arguments);
        let process = format!("another run (process {})", std::process::id());
        assert!(message.contains(&process), "{command}: {message}");
    }
    drop(lock);
    let entries = std::fs::read_dir(out.path()).unwrap();
    assert_eq!(entries.count(), 0);
}

/// Stokes drag: the displacement is `F t / (6 π μ a)`.
#[test]
fn a_sweep_writes_a_table_and_a_picture_and_continues() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let scene = "model.kind = \"multipole\"\nbodies = [{ name = \"a\", radius = 1, position = [0, 0, 0], \
                 force = [1, 0, 0] }]\ngait.phases = [{ duration = 1 }]\n";
    std::fs::write(folder.join("scene.toml"), scene).unwrap();
    let sweep = [
        "sweep",
        "scene.toml",
        "--vary",
        "bodies.a.radius=0.5:2:4:log",
        "--vary",
        "fluid.viscosity=1,2,-2",
        "--out",
        "out",
    ];
    let output = swim(folder, &sweep);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stderr).contains("4 of 12 runs failed"));
    assert!(text(&output.stdout).contains("failed: "), "the reason");
    let table = std::fs::read_to_string(folder.join("out/sweep.csv")).unwrap();
    let rows: Vec<Vec<&str>> = table
        .lines()
        .map(|line| line.split(',').collect())
        .collect();
    assert_eq!(rows.len(), 13);
    assert_eq!(
        rows[0][..4],
        ["bodies.a.radius", "fluid.viscosity", "model", "status"]
    );
    let met: Vec<_> = rows[1..].iter().filter(|row| row[3] == "met").collect();
    assert_eq!(met.len(), 8);
    for row in met {
        let [radius, viscosity, found] = [0, 1, 4].map(|k| row[k].parse::<f64>().unwrap());
        let exact = 1.0 / (6.0 * std::f64::consts::PI * radius * viscosity);
        assert!((found - exact).abs() < 1e-12 * exact, "{row:?}");
    }
    assert!(folder.join("out/sweep.svg").exists());
    // All rows are known.
    let mut arguments = sweep.to_vec();
    arguments.extend(["--resume", "--json"]);
    let again = json(folder, &arguments);
    assert_eq!(again["rows"].as_array().unwrap().len(), 12);
    let after = std::fs::read_to_string(folder.join("out/sweep.csv")).unwrap();
    assert_eq!(table, after, "with the times of the first runs");
    let unknown = ["sweep", "scene.toml", "--vary", "fluid.colour=1,2"];
    assert!(refused(folder, &unknown).contains("fluid.colour"));
    let bare = ["sweep", "scene.toml", "--vary", "fluid.viscosity=1:2"];
    assert!(refused(folder, &bare).contains("has no count"));
}

/// The best number of waves of a tail, with a table, an optimum and its scene; limits of the phase
/// belong to strokes.
#[test]
#[ignore = "slow: 3 min"]
fn the_best_wave_of_a_tail_is_printed_with_its_bar() {
    let temporary = template("sperm");
    let folder = temporary.path();
    let ranges = "optimise.waves=[0.7, 1.5]";
    let sets = [
        "--set",
        ranges,
        "--set",
        "fem.surface_size=0.8",
        "--set",
        "model.tolerance=0.9",
    ];
    let mut arguments = vec!["optimise", "scene.toml", "--out", "out"];
    arguments.extend(sets);
    let printed_text = printed(folder, &arguments);
    let parts = [
        "table                   5 runs",
        "best waves",
        "efficiency by table",
        "by its run",
    ];
    contains("optimise", &printed_text, &parts);
    let json = std::fs::read_to_string(folder.join("out/optimum.json")).unwrap();
    let json: Value = serde_json::from_str(&json).unwrap();
    let undescribed = crate::schemas::output_problems(folder, "wave", &json);
    assert!(undescribed.is_empty(), "{undescribed:#?}");
    let [best, by_table] = ["value", "by_table"].map(|key| json[key].as_f64().unwrap());
    let rows = json["table"]["rows"].as_array().unwrap();
    let largest = (rows.iter())
        .map(|row| row["result"]["efficiency"].as_f64().unwrap())
        .fold(0.0, f64::max);
    let bar = json["error"].as_f64().unwrap();
    assert!(
        by_table >= largest && best >= largest - bar,
        "{best} {by_table} {largest}"
    );
    assert!(folder.join("out/optimum.toml").exists() && folder.join("out/sweep.csv").exists());
    let mut both = arguments.clone();
    both.extend(["--set", "optimise.objective=energy"]);
    refused(folder, &both);
}

/// Arm and volume are the two shape coordinates of the pushmepullyou: their curvature is drawn, and
/// the best stroke is more efficient than the square of the template.
#[test]
#[ignore = "slow: 60 s"]
fn the_pushmepullyou_has_a_map_and_a_best_stroke() {
    let temporary = template("pushmepullyou");
    let folder = temporary.path();
    let map = [
        "map",
        "scene.toml",
        "--out",
        "map",
        "--set",
        "optimise.tolerance=1e-2",
    ];
    contains(
        "map",
        &printed(folder, &map),
        &["curvature over arm and volume"],
    );
    let picture = std::fs::read_to_string(folder.join("map/map.svg")).unwrap();
    assert!(picture.contains("arm") && picture.contains("volume"));
    let mut optimise = map;
    (optimise[0], optimise[3]) = ("optimise", "best");
    let mut optimise = optimise.to_vec();
    optimise.extend(["--set", "optimise.terms=8", "--json"]);
    let found: Value = serde_json::from_str(&printed(folder, &optimise)).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let (run, table) = (&found["run"], &found["table"]);
    let bar = number(&run["displacement_error"]) + number(&table["displacement_error"]);
    let displacement = number(&found["displacement"]);
    assert!((displacement - number(&run["displacement"])).abs() < bar);
    // Displacement and product of energy and period of the square, computed for this project by
    // Lamb's solution.
    let square = 0.650163426803_f64.powi(2) / 1324.39538651;
    let best = displacement.powi(2) / number(&found["period_energy_product"]);
    assert!(best > 1.05 * square, "{best} {square}");
    let efficiency = &run["efficiency"];
    assert!(number(&efficiency["error"]) < 0.01 * number(&efficiency["value"]));
}
