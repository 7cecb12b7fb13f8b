//! What the command prints are the numbers of its JSON, rounded.

use std::path::Path;

use serde_json::Value;
use testkit::within;

use crate::text;

/// Standard output and standard error of a successful command.
fn swim(arguments: &[&str]) -> (String, String) {
    let output = crate::swim(Path::new("."), arguments);
    assert!(output.status.success(), "{}", text(&output.stderr));
    (text(&output.stdout), text(&output.stderr))
}

/// The text after a label at the start of a line.
fn after<'a>(text: &'a str, label: &str) -> &'a str {
    let found = text.lines().find_map(|line| line.strip_prefix(label));
    found
        .unwrap_or_else(|| panic!("no line with '{label}':\n{text}"))
        .trim()
}

fn number(text: &str) -> f64 {
    let first = text.split_whitespace().next().unwrap_or_default();
    first.parse().unwrap_or_else(|_| panic!("{text}"))
}

/// Value and uncertainty of `1.60 +- 0.04 (2.5 %)` or `(1.60 +- 0.04)e-7 (2.5 %)`.
fn with_uncertainty(text: &str) -> [f64; 2] {
    let (numbers, scale) = match text
        .strip_prefix('(')
        .and_then(|rest| rest.split_once(")e"))
    {
        Some((numbers, rest)) => (
            numbers,
            format!("1e{}", rest.split_whitespace().next().unwrap()),
        ),
        None => (text, "1".to_owned()),
    };
    let (value, uncertainty) = numbers.split_once(" +- ").unwrap();
    [value, uncertainty].map(|part| number(part) * number(&scale))
}

/// Asserts that two digits of `printed` are those of `exact`.
fn assert_two_digits(what: &str, printed: f64, exact: f64) {
    let why = "half a unit of the second digit is at most a twentieth";
    within(
        printed - exact,
        0.0501 * exact.abs(),
        format!("{why}: {what}"),
    );
}

fn vector(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|axis| value[axis].as_f64().unwrap())
}

/// A planar swimmer that rotates, in metres: its displacements are micrometres.
const PLANAR: &str = r#"
    model = { kind = "rpy", tolerance = 1e-2 }
    gait.cycles = 2
    bodies = [
        { name = "hub", shape = "point", position = [0, 0, 0] },
        { name = "one", radius = 1e-6, position = [6e-6, 0, 0] },
        { name = "two", radius = 1e-6, position = [-3e-6, 5e-6, 0] },
        { name = "three", radius = 1e-6, position = [-3e-6, -5e-6, 0] },
    ]
    links = [
        { name = "arm-1", body = "one", to = "hub" },
        { name = "arm-2", body = "two", to = "hub" },
        { name = "arm-3", body = "three", to = "hub" },
    ]
    gait.phases = [
        { link = "arm-1", length = 4e-6 },
        { link = "arm-2", length = 4e-6 },
        { link = "arm-1", length = 6e-6 },
        { link = "arm-2", length = 6e-6 },
    ]
"#;

#[test]
fn a_run_prints_the_numbers_of_its_summary() {
    let folder = tempfile::tempdir().unwrap();
    let [scene, out] = ["planar.toml", "out"].map(|name| folder.path().join(name));
    std::fs::write(&scene, PLANAR).unwrap();
    let [from, to] = [&scene, &out].map(|path| path.to_str().unwrap());
    let (text, _) = swim(&["run", from, "--out", to]);
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&summary).unwrap();

    // The table: phases, then the total, with a common power of ten and five decimals.
    let unit = 1e-6;
    let lines = text.lines();
    let mut table = lines.skip_while(|line| !line.starts_with("displacements"));
    let head = table.next().unwrap();
    assert!(head.contains(" in 1e-6 of the scene's unit"), "{head}");
    let names: Vec<&str> = table.next().unwrap().split_whitespace().skip(1).collect();
    assert_eq!(names, ["hub", "one", "two", "three"]);
    let phases = summary["phases"].as_array().unwrap();
    assert_eq!(phases.len(), 8);
    let rows = phases.iter().chain([&summary]);
    for (line, row) in table.zip(rows) {
        let cells: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(cells[0], row["link"].as_str().unwrap_or("total"));
        let bar = row["error_estimate"]["total"].as_f64().unwrap();
        for (body, name) in names.iter().enumerate() {
            let displacement = vector(&row["displacement"][*name]);
            for (axis, exact) in displacement.into_iter().enumerate() {
                let printed = number(cells[1 + 3 * body + axis]) * unit;
                let shown = if exact.abs() > bar { exact } else { 0.0 };
                within(
                    printed - shown,
                    0.51e-5 * unit,
                    format!("five decimals: {line}"),
                );
            }
        }
    }

    let bodies = names
        .iter()
        .map(|name| vector(&summary["displacement"][*name]));
    let mean = bodies.fold([0.0; 3], |[x, y, z], d| {
        [x + d[0] / 4.0, y + d[1] / 4.0, z + d[2] / 4.0]
    });
    let net = mean.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [value, bar] = with_uncertainty(after(&text, "net displacement"));
    let exact_bar = summary["error_estimate"]["total"].as_f64().unwrap();
    assert_two_digits("bar of the net displacement", bar, exact_bar);
    within(
        value - net,
        0.051 * exact_bar,
        "half of the second digit of the bar",
    );
    for source in ["model", "integration"] {
        let printed = number(after(&text, &format!("  {source}")));
        let exact = summary["error_estimate"][source].as_f64().unwrap();
        assert_two_digits(source, printed, exact);
    }
    assert_two_digits("sum", number(after(&text, "  sum")), exact_bar);
    assert!(after(&text, "  not estimated").contains("container"));

    let [value, bar] = with_uncertainty(after(&text, "work on the fluid"));
    let work = summary["work"].as_f64().unwrap();
    let exact_bar = summary["work_error"]["total"].as_f64().unwrap();
    assert_two_digits("bar of the work", bar, exact_bar);
    within(
        value - work,
        0.051 * exact_bar,
        "half of the second digit of the bar",
    );

    let rotation = after(&text, "rotation vector").trim_start_matches('(');
    let printed: Vec<f64> = rotation.split([',', ')']).take(3).map(number).collect();
    let bar = summary["rotation_error"]["total"].as_f64().unwrap();
    for (printed, exact) in printed.iter().zip(vector(&summary["rotation"])) {
        let shown = if exact.abs() > bar { exact } else { 0.0 };
        within(
            printed - shown,
            0.051 * bar,
            format!("half of the second digit of the bar: {rotation}"),
        );
    }
    assert!(printed[2] > 0.01, "{rotation}");
    let solves = summary["solves"].as_u64().unwrap();
    assert!(after(&text, "cost").starts_with(&format!("{solves} solves, ")));
    // All solves of all phases are counted, and apart from them those that were looked up.
    let sum = |key: &str| -> u64 {
        let numbers = phases.iter().map(|phase| phase[key].as_u64().unwrap());
        numbers.sum()
    };
    let of_tables = summary["table_solves"].as_u64().unwrap();
    assert_eq!(sum("solves") + of_tables, solves);
    assert_eq!(sum("lookups"), summary["lookups"].as_u64().unwrap());
}

/// Two equal spheres that an arm pushes apart: errors of forces are twenty times those of
/// velocities, which the rate of the arm determines.
const PAIR: &str = r#"
    domain = { kind = "ball", radius = 12 }
    model.kind = "fem"
    fem = { size_factor = 2.0, target = 3e-3 }
    bodies = [
        { name = "a", radius = 1, position = [-2, 0, 0] },
        { name = "b", radius = 1, position = [2, 0, 0] },
    ]
    links = [{ name = "arm", body = "b", to = "a" }]
    gait.phases = [{ link = "arm", length = 4.5 }]
"#;

#[test]
fn solve_prints_the_numbers_of_its_json_and_warns_about_the_larger_error() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("pair.toml");
    std::fs::write(&scene, PAIR).unwrap();
    let scene = scene.to_str().unwrap();
    let (text, warning) = swim(&["solve", scene]);
    let (json, _) = swim(&["solve", scene, "--json"]);
    let answer: Value = serde_json::from_str(&json).unwrap();

    let mut lines = text.lines().skip_while(|line| !line.starts_with("body "));
    let mut check = |label: &str, exact: &Value, bar: f64| {
        let line = lines.next().unwrap();
        let printed = line.trim_start().strip_prefix(label);
        let printed = printed.unwrap_or_else(|| panic!("{label}: {line}"));
        if let Value::String(name) = exact {
            return assert_eq!(printed.trim(), name);
        }
        for (printed, exact) in printed.split_whitespace().zip(vector(exact)) {
            let shown = if exact.abs() > bar { exact } else { 0.0 };
            within(
                number(printed) - shown,
                0.051 * bar,
                format!("half of the second digit of the bar: {line}"),
            );
        }
    };
    let estimates = &answer["error_estimate"];
    let bar = |key: &str| estimates[key]["total"].as_f64().unwrap();
    for body in answer["bodies"].as_array().unwrap() {
        check("body", &body["name"], 0.0);
        let of_velocity = estimates["total"].as_f64().unwrap();
        check("velocity", &body["velocity"], of_velocity);
        let of_rotation = bar("angular_velocity");
        check("angular velocity", &body["angular_velocity"], of_rotation);
        check("force on the fluid", &body["force"], bar("force"));
        check("torque on the fluid", &body["torque"], bar("torque"));
        let of_stresslet = estimates["stresslet"].as_f64().unwrap();
        for (label, row) in ["stresslet", "", ""].into_iter().zip(0..) {
            check(label, &body["stresslet"][row], of_stresslet);
        }
    }
    check("link", &answer["links"][0]["name"], 0.0);
    check("force on b", &answer["links"][0]["force"], bar("force"));
    let drive = &answer["links"][0]["drive"];
    check(
        "force of the drive",
        &serde_json::json!([drive, 0, 0]),
        bar("force"),
    );
    // A slide along x between spheres on that axis: its drive is the force.
    assert_eq!(*drive, answer["links"][0]["force"][0]);
    assert_eq!(
        answer["links"][0]["torque"],
        serde_json::json!([0.0, 0.0, 0.0])
    );
    // The joint exerts the whole force on its body.
    assert!(answer["links"][0]["force"][0].as_f64().unwrap() > 1.0);

    let estimate = |key: &str| answer["error_estimate"][key].as_f64().unwrap();
    assert_two_digits("mesh", number(after(&text, "  mesh")), estimate("mesh"));
    assert_two_digits("sum", number(after(&text, "  sum")), estimate("total"));
    let force = answer["error_estimate"]["force"]["mesh"].as_f64().unwrap();
    assert_two_digits("force", number(after(&text, "error of forces")), force);
    for (label, key) in [
        ("check of forces", "force_by_stress"),
        ("check of power", "dissipation"),
    ] {
        let percent = number(after(&text, label));
        let exact = answer["checks"][key].as_f64().unwrap();
        assert_two_digits(label, percent, 100.0 * exact);
    }
    let dofs = answer["dofs"]["total"].as_u64().unwrap();
    assert_eq!(after(&text, "degrees of freedom"), dofs.to_string());
    let dofs_of = |key: &str| answer["dofs"][key].as_u64().unwrap();
    // One dof more: the speed of the pair.
    assert!((1..12).contains(&(dofs - dofs_of("velocity") - dofs_of("pressure"))));
    let iterations = answer["solver"]["iterations"].as_u64().unwrap();
    assert!(after(&text, "solver").contains(&format!("{iterations} iterations")));

    // The error of the forces is above the target, that of the velocities below.
    let (speed, size) = (
        answer["bodies"][0]["velocity"][0].as_f64().unwrap().abs(),
        answer["bodies"][0]["force"][0].as_f64().unwrap().abs(),
    );
    assert!(estimate("mesh") < 3e-3 * speed && force > 3e-3 * size);
    let words = warning
        .strip_prefix("warning: fem.target = 3e-3 allows")
        .unwrap();
    let (of_force, of_velocity) = words.split_once(" of the largest force and ").unwrap();
    let of_force = of_force.rsplit_once("is ").unwrap().1;
    assert_two_digits("force", number(of_force), 100.0 * force / size);
    let percent = 100.0 * estimate("mesh") / speed;
    assert_two_digits("velocity", number(of_velocity), percent);
}

#[test]
fn bug_numbers_far_from_one_were_printed_as_zero() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tiny.toml");
    let tiny = "fluid.viscosity = 1e-3\n\
        bodies = [{ name = \"a\", radius = 1e-3, position = [0, 0, 0], force = [1e-13, 0, 0] }]\n";
    std::fs::write(&path, tiny).unwrap();
    let (text, _) = swim(&["solve", path.to_str().unwrap()]);
    let words = |label: &str| -> Vec<String> {
        after(&text, label)
            .split_whitespace()
            .map(str::to_owned)
            .collect()
    };
    // `F / (6 π μ a)`.
    assert_eq!(words("  velocity"), ["5.305164770e-9", "0", "0"]);
    assert_eq!(words("  force on the fluid"), ["1.000000000e-13", "0", "0"]);
}

#[test]
fn bug_a_small_component_beside_a_large_one_was_printed_as_zero() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("oblique.toml");
    let oblique =
        "bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0], force = [1, 1e-9, 1e-18] }]\n";
    std::fs::write(&path, oblique).unwrap();
    let (text, _) = swim(&["solve", path.to_str().unwrap()]);
    let words: Vec<&str> = after(&text, "  velocity").split_whitespace().collect();
    // The last component is rounding of the first.
    assert_eq!([words[0], words[2]], ["0.05305164770", "0"]);
    assert!(
        words[1].starts_with("5.30516") && words[1].ends_with("e-11"),
        "{words:?}"
    );
}

#[test]
fn bug_checks_relative_to_a_force_or_a_power_of_zero_were_printed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("still.toml");
    let still = "domain = { kind = \"ball\", radius = 4 }\n\
        model.kind = \"fem\"\n\
        fem.size_factor = 2.0\n\
        bodies = [{ name = \"a\", radius = 1, position = [0.5, 0, 0] }]\n";
    std::fs::write(&path, still).unwrap();
    let path = path.to_str().unwrap();
    let (text, _) = swim(&["solve", path]);
    assert!(!text.contains("check of"), "{text}");
    let (text, _) = swim(&["solve", path, "--set", "bodies.a.torque=[1, 0, 0]"]);
    assert!(!text.contains("check of forces"), "{text}");
    assert!(text.contains("check of power"), "{text}");
}

/// Two spheres side by side.
const PAIR_OF_SPHERES: &str = r#"
    bodies = [
        { name = "a", radius = 1, position = [0, 0, 0], force = [1, 0, 0] },
        { name = "b", radius = 1, position = [2.1, 0, 0] },
    ]
"#;

/// The models that control their error are too exact to miss one; see the tests of `solve.rs`.
#[test]
fn bug_solve_ignored_the_tolerance() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("pair.toml"), PAIR_OF_SPHERES).unwrap();
    let met = crate::printed(folder.path(), &["solve", "pair.toml", "--json"]);
    let answer: Value = serde_json::from_str(&met).unwrap();
    assert_eq!(answer["tolerance_met"], true);
    assert_eq!(answer["tolerance_limits"], "all errors");
    // A model that does not control its error, as in a run.
    let rough = ["solve", "pair.toml", "--set", "model.kind=rpy"];
    let printed = crate::printed(folder.path(), &rough);
    let words = after(&printed, "tolerance");
    assert!(
        words.contains("does not limit the errors of this model"),
        "{words}"
    );
    // One that is asked for and missed: exit 3 with the result, unless the best is accepted.
    let asked = [&rough[..], &["--set", "model.tolerance=1e-6"]].concat();
    let output = crate::swim(folder.path(), &asked);
    assert_eq!(output.status.code(), Some(3));
    let [text, message] = [&output.stdout, &output.stderr].map(|bytes| text(bytes));
    assert!(text.contains("velocity"), "{text}");
    assert!(
        message.contains("let model.kind = \"auto\" choose"),
        "{message}"
    );
    let accepted = [&asked[..], &["--set", "model.accept=best"]].concat();
    crate::printed(folder.path(), &accepted);
}

/// The remedy was to let `auto` choose, which had chosen.
#[test]
fn bug_the_remedy_for_a_missed_tolerance_in_a_periodic_box_was_the_model_that_missed_it() {
    let folder = tempfile::tempdir().unwrap();
    let boxed = format!(
        "domain = {{ kind = \"periodic\", size = [6, 6, 6] }}\nmodel.tolerance = 1e-4\n\
         {PAIR_OF_SPHERES}"
    );
    std::fs::write(folder.path().join("boxed.toml"), boxed).unwrap();
    let rough = ["solve", "boxed.toml", "--set", "model.kind=rpy"];
    let output = crate::swim(folder.path(), &rough);
    assert_eq!(output.status.code(), Some(3));
    let message = text(&output.stderr);
    let remedy = "set model.kind = \"multipole\"";
    assert!(message.contains(remedy), "{message}");
    let better = ["solve", "boxed.toml", "--set", "model.kind=multipole"];
    crate::printed(folder.path(), &better);
    // `auto` chose rpy, however few the spheres.
    crate::printed(folder.path(), &["solve", "boxed.toml"]);
}

#[test]
fn bug_displacements_by_rounding_were_printed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("motor.toml");
    let motor = r#"
        bodies = [
            { name = "a", radius = 1, position = [0, 0, 0] },
            { name = "b", radius = 2, position = [4, 0, 0] },
        ]
        links = [{ name = "m", joint = "rotor", body = "a", to = "b", axis = [1, 0, 0] }]
        gait.phases = [{ link = "m", length = 6 }]
    "#;
    std::fs::write(&path, motor).unwrap();
    let out = folder.path().join("out");
    let (text, _) = swim(&[
        "run",
        path.to_str().unwrap(),
        "--out",
        out.to_str().unwrap(),
    ]);
    let words = after(&text, "total").split_whitespace();
    assert!(words.into_iter().all(|word| word == "0.00000"), "{text}");
    let net = after(&text, "net displacement").trim_start_matches('(');
    assert_eq!(number(net), 0.0, "{text}");
}

#[test]
fn bug_the_tolerance_was_met_beside_a_bar_of_a_model_that_it_does_not_limit() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("three-sphere.toml");
    crate::swim(folder.path(), &["new", "three-sphere"]);
    let out = folder.path().join("out");
    let (text, _) = swim(&[
        "run",
        scene.to_str().unwrap(),
        "--set",
        "model.kind=oseen",
        "--set",
        "domain.kind=unbounded",
        "--out",
        out.to_str().unwrap(),
    ]);
    let words = after(&text, "tolerance");
    assert!(
        words.contains("does not limit the errors of the model"),
        "{text}"
    );
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(summary["tolerance_limits"], "the error of the integration");
}

/// A pair of unequal spheres whose arm stays shorter, and turns with a rotor.
const OPEN: &str = r#"
    model = { kind = "rpy", tolerance = 1e-2 }
    bodies = [
        { name = "hub", radius = 2, position = [0, 0, 0] },
        { name = "tip", radius = 1, position = [8, 0, 0] },
    ]
    links = [{ name = "arm", body = "tip", to = "hub" }]
    gait.phases = [{ link = "arm", length = 6 }]
"#;

#[test]
fn bug_an_open_gait_printed_a_net_displacement_without_saying_that_the_shape_is_another_one() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("open.toml"), OPEN).unwrap();
    let run = |settings: &[&str]| {
        let arguments = [&["run", "open.toml", "--out", "out"], settings].concat();
        let printed = crate::printed(folder.path(), &arguments);
        let out = folder.path().join("out");
        let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
        let page = std::fs::read_to_string(out.join("report.html")).unwrap();
        (
            printed,
            serde_json::from_str::<Value>(&summary).unwrap(),
            page,
        )
    };
    let (printed, summary, page) = run(&[]);
    let words = after(&printed, "shape ");
    assert!(
        words.starts_with("another one at the end (arm -2.0000)"),
        "{words}"
    );
    let change = &summary["shape_change"];
    assert_eq!(change["links"]["arm"], -2.0);
    let rigid = &change["rigid_part"];
    assert_eq!(rigid["body"], "hub");
    assert_eq!(rigid["displacement"], summary["displacement"]["hub"]);
    let moved = vector(&rigid["displacement"])[0];
    let words = after(&printed, "rigid part")
        .strip_prefix("displacement (")
        .unwrap();
    let bar = summary["error_estimate"]["total"].as_f64().unwrap();
    let printed_number: f64 = words.split(',').next().unwrap().parse().unwrap();
    within(
        printed_number - moved,
        0.051 * bar,
        "half of the second digit of the bar",
    );
    assert!(page.contains("another one at the end (arm -2.0000)"));
    // A gait that closes says nothing, nor does a full turn.
    let closed = "gait.phases=[{link=\"arm\",length=6},{link=\"arm\",length=8}]";
    let rotor = [
        "links.arm.joint=rotor",
        "gait.phases=[{link=\"arm\",length=6.283185307179586}]",
    ];
    for settings in [
        &["--set", closed][..],
        &["--set", rotor[0], "--set", rotor[1]],
    ] {
        let (printed, summary, page) = run(settings);
        assert!(!printed.contains("another one at the end"), "{printed}");
        assert!(!page.contains("another one at the end"));
        assert_eq!(summary["shape_change"], Value::Null);
    }
}

#[test]
fn a_quiet_run_prints_one_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("open.toml"), OPEN).unwrap();
    let arguments = ["run", "open.toml", "--out", "out"];
    let line = crate::printed(folder.path(), &[&arguments[..], &["--quiet"]].concat());
    assert_eq!(line.lines().count(), 1, "{line}");
    let whole = crate::printed(folder.path(), &arguments);
    assert_eq!(
        after(&line, "net displacement"),
        after(&whole, "net displacement")
    );
}

#[test]
fn bug_look_ups_in_tables_were_counted_as_solves() {
    let folder = tempfile::tempdir().unwrap();
    crate::swim(folder.path(), &["new", "three-sphere"]);
    let settings = ["domain.kind=unbounded", "model.kind=rpy", "gait.cycles=3"];
    let settings = settings.iter().flat_map(|setting| ["--set", setting]);
    let arguments = ["run", "three-sphere.toml", "--out", "out"];
    let arguments: Vec<&str> = arguments.into_iter().chain(settings).collect();
    let printed = crate::printed(folder.path(), &arguments);
    let summary = std::fs::read_to_string(folder.path().join("out/summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&summary).unwrap();
    let [solves, of_tables, lookups] =
        ["solves", "table_solves", "lookups"].map(|key| summary[key].as_u64().unwrap());
    // All solves are those of the tables.
    assert!(solves > 0 && solves == of_tables && lookups > 0);
    let words = format!("{solves} solves, {lookups} look-ups in tables, ");
    assert!(after(&printed, "cost").starts_with(&words), "{printed}");
}

/// The meridian plane stops at a relative error of 1e-11 of resistances: a tolerance below its bar
/// is missed, which the status says, and accepted on request.
#[test]
fn a_missed_tolerance_of_a_solution_is_status_3_unless_the_best_is_accepted() {
    let folder = tempfile::tempdir().unwrap();
    let scene = |accept: &str| {
        let text = format!(
            "model = {{ kind = \"axisymmetric\", tolerance = 1e-12{accept} }}\n\
             bodies = [\n\
             {{ name = \"a\", radius = 1, position = [0, 0, 0], force = [1, 0, 0] }},\n\
             {{ name = \"b\", radius = 1, position = [2.01, 0, 0] }},\n]"
        );
        std::fs::write(folder.path().join("scene.toml"), text).unwrap();
        crate::swim(folder.path(), &["solve", "scene.toml"])
    };
    let missed = scene("");
    let message = text(&missed.stderr);
    assert_eq!(missed.status.code(), Some(3), "{message}");
    let parts = [
        "scene.toml:1: model.tolerance = 1e-12 allows",
        "was reached",
        "model.accept",
    ];
    for part in parts {
        assert!(message.contains(part), "{part}: {message}");
    }
    let best = scene(", accept = \"best\"");
    let message = text(&best.stderr);
    assert_eq!(best.status.code(), Some(0), "{message}");
    // after lines of progress on a slow machine
    let mut lines = message.lines();
    assert!(lines.any(|line| line.starts_with("warning: ")), "{message}");
    assert!(message.contains("was reached"), "{message}");
    let printed = text(&best.stdout);
    assert!(printed.contains("is not met"), "{printed}");
}
