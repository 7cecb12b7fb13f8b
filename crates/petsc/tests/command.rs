//! The command `swim-petsc` against the model of one machine.

use std::path::Path;
use std::process::{Command, Output};

use swimmer::models::{FemModel, InstantaneousSolution};
use swimmer::{Choice, Progress, Scene, run_with, solve_start};

/// Residual of the solves; answers agree to the larger [`AGREEMENT`].
const RTOL: f64 = 1e-11;
const AGREEMENT: f64 = 1e-8;

/// Three spheres on one axis, of which a quarter is meshed.
const SWIMMER: &str = r#"
[domain]
kind = "ball"
radius = 20.0

[[bodies]]
name = "left"
shape = "sphere"
radius = 1.0
position = [-4.0, 0.0, 0.0]

[[bodies]]
name = "centre"
shape = "sphere"
radius = 1.0
position = [0.0, 0.0, 0.0]

[[bodies]]
name = "right"
shape = "sphere"
radius = 1.0
position = [4.0, 0.0, 0.0]

[[links]]
name = "left arm"
body = "left"
to = "centre"

[[links]]
name = "right arm"
body = "right"
to = "centre"

[gait]
arms = "clamped"

[[gait.phases]]
link = "left arm"
length = 3.0
duration = 1.0
"#;

/// A squirmer off the centre of a ball: prescribed velocities on a surface.
const SQUIRMER: &str = r#"
[domain]
kind = "ball"
radius = 8.0

[[bodies]]
name = "squirmer"
shape = "sphere"
radius = 1.0
position = [1.0, 2.0, 0.5]
slip = { b1 = 1.0, b2 = 2.0, axis = [1.0, 0.0, 0.5] }
"#;

/// Two spheres in a channel, at a gap of a tenth of a radius.
///
/// Without the Laplacian of the pressure the iteration takes twice as many steps.
const CHANNEL: &str = r#"
[domain]
kind = "box"
size = [40.0, 5.0, 5.0]

[[bodies]]
name = "pulled"
radius = 1.0
position = [-1.05, 0.3, 0.2]
force = [1.0, 0.0, 0.0]

[[bodies]]
name = "free"
radius = 1.0
position = [1.05, 0.3, 0.2]
"#;

/// Largest ratio of the iterations to those on one machine.
///
/// Hypre's cycle on the Laplacian is not that of `linalg`: in channels it takes a fifth more.
const MORE_ITERATIONS: f64 = 1.25;

/// Difference of corrected numbers between solvers, as a fraction of the correction.
///
/// Corrections take a fixed number of iterations, with different preconditioners; this part of
/// their uncertainty is that of `stokes`.
const OF_CORRECTIONS: f64 = 0.015;

/// Relative difference of error bars: unit loads are solved to a residual of 1e-2.
const OF_BARS: f64 = 0.02;

/// Keys by which both programs compute the same numbers, with or without `estimates`.
fn overrides(estimates: &str) -> Vec<String> {
    vec![
        "model.kind=\"fem\"".to_owned(),
        format!("fem.estimates=\"{estimates}\""),
        "fem.surface_size=0.7".to_owned(),
        format!("fem.rtol={RTOL:e}"),
    ]
}

fn swim_petsc(ranks: usize, task: &[&str], scene: &Path, estimates: &str) -> Output {
    let mut command = Command::new("mpirun");
    command
        .args(["--oversubscribe", "--allow-run-as-root", "-n"])
        .arg(ranks.to_string())
        .arg(env!("CARGO_BIN_EXE_swim-petsc"))
        .arg(task[0])
        .arg(scene)
        .args(&task[1..])
        .env("RAYON_NUM_THREADS", "1");
    for key in overrides(estimates) {
        command.args(["--set", &key]);
    }
    command.output().expect("mpirun, from openmpi-bin")
}

fn on_one_machine(scene: &Path, estimates: &str) -> InstantaneousSolution {
    let scene = Scene::read(scene, &overrides(estimates)).expect("a sound scene");
    let mut model = FemModel::new(&scene).expect("a scene for elements");
    solve_start(&scene, &mut model).expect("a solution")
}

/// The JSON object that a command prints.
fn answer(output: Output) -> serde_json::Value {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).expect("one JSON object, printed once")
}

/// Compares corrected velocities and forces, and their error bars, on 3 processes with one machine.
fn compare_corrected(name: &str, text: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(format!("{name}.toml"));
    std::fs::write(&path, text).expect("a file");
    let expected = on_one_machine(&path, "on");
    let uncorrected = expected.uncorrected();
    let answer = answer(swim_petsc(3, &["solve"], &path, "on"));
    type Part = fn(&swimmer::models::BodySolution) -> nalgebra::Vector3<f64>;
    let parts: [(&str, Part); 3] = [
        ("velocity", |body| body.velocity),
        ("angular_velocity", |body| body.angular_velocity),
        ("force", |body| body.force),
    ];
    for (key, of) in parts {
        let pairs = expected.bodies.iter().zip(&uncorrected.bodies);
        let corrections = pairs.map(|(with, without)| (of(with) - of(without)).norm());
        let correction = corrections.fold(AGREEMENT, f64::max);
        for (body, expected) in expected.bodies.iter().enumerate() {
            for axis in 0..3 {
                let found = answer["bodies"][body][key][axis].as_f64();
                let difference = (found.expect("a number") - of(expected)[axis]).abs();
                let relative = difference / correction;
                assert!(
                    relative < OF_CORRECTIONS,
                    "{key}: {relative:e} of {correction:e}"
                );
            }
        }
    }
    let found = &answer["error_estimate"];
    for (found, expected) in [
        (&found["mesh"], expected.error_estimate.mesh),
        (&found["force"]["mesh"], expected.force_error.mesh),
    ] {
        let (found, expected) = (found.as_f64().expect("a bar"), expected.expect("a bar"));
        // Bodies without joints or supports have the given loads, without error.
        let difference = (found - expected).abs() / expected.max(f64::MIN_POSITIVE);
        assert!(difference < OF_BARS, "{found} {expected}");
    }
    let dissipation = answer["checks"]["dissipation"].as_f64().expect("a check");
    let checks = expected.checks.expect("checks");
    assert!((dissipation - checks.dissipation).abs() < AGREEMENT);
}

/// Compares velocities and forces of all bodies on 1 and 3 processes with one machine.
fn compare(name: &str, text: &str) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(format!("{name}.toml"));
    std::fs::write(&path, text).expect("a file");
    let expected = on_one_machine(&path, "off");
    let largest = |of: fn(&swimmer::models::BodySolution) -> f64| {
        expected.bodies.iter().map(of).fold(1e-3, f64::max)
    };
    let [speed, force] = [
        largest(|body| body.velocity.norm()),
        largest(|body| body.force.norm()),
    ];
    for ranks in [1, 3] {
        let answer = answer(swim_petsc(ranks, &["solve"], &path, "off"));
        assert_eq!(answer["solver"]["solver"], "petsc block");
        let iterations = answer["solver"]["iterations"].as_f64().expect("a number");
        let most = MORE_ITERATIONS * expected.solver.iterations as f64;
        assert!(
            iterations <= most,
            "{ranks} processes: {iterations} > {most}"
        );
        for (body, found) in expected.bodies.iter().enumerate() {
            let found_of = |key: &str, axis: usize| answer["bodies"][body][key][axis].as_f64();
            for axis in 0..3 {
                let pairs = [
                    (found_of("velocity", axis), found.velocity[axis], speed),
                    (
                        found_of("angular_velocity", axis),
                        found.angular_velocity[axis],
                        speed,
                    ),
                    (found_of("force", axis), found.force[axis], force),
                ];
                for (found, expected, size) in pairs {
                    let difference = (found.expect("a number") - expected).abs() / size;
                    assert!(difference < AGREEMENT, "{ranks} processes: {difference:e}");
                }
            }
        }
    }
}

#[test]
fn a_swimmer_cut_at_symmetry_planes_is_the_same_on_one_machine() {
    compare("swimmer", SWIMMER);
}

#[test]
fn a_squirmer_is_the_same_on_one_machine() {
    compare("squirmer", SQUIRMER);
}

#[test]
fn corrected_numbers_of_a_swimmer_are_those_of_one_machine() {
    compare_corrected("swimmer", SWIMMER);
}

#[test]
fn corrected_numbers_of_a_squirmer_are_those_of_one_machine() {
    compare_corrected("squirmer", SQUIRMER);
}

#[test]
fn a_channel_with_a_narrow_gap_takes_the_iterations_of_one_machine() {
    compare("channel", CHANNEL);
}

#[test]
fn an_error_ends_all_processes_with_its_exit_code() {
    let output = swim_petsc(2, &["solve"], Path::new("no-such-scene.toml"), "on");
    assert_eq!(output.status.code(), Some(2));
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(errors.contains("no-such-scene.toml"), "{errors}");
}

/// Net displacements of a run; the same once more from its checkpoint.
#[test]
fn a_gait_moves_as_on_one_machine_and_resumes() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("swimmer.toml");
    let text = format!("{SWIMMER}\n[model]\naccept = \"best\"\n");
    std::fs::write(&path, text).expect("a file");
    let scene = Scene::read(&path, &overrides("off")).expect("a sound scene");
    let elements = |scene: &Scene, _: &mut dyn Progress| {
        Ok(Choice::new(Box::new(FemModel::new(scene)?), Vec::new()))
    };
    let alone = folder.path().join("alone");
    let expected =
        run_with(scene, &elements, &alone, false, true, &mut (), &mut ()).expect("a run");
    let expected = expected.outcome.displacement[0].x;
    let out = folder.path().join("out");
    let out = out.to_str().expect("a path of letters");
    for task in [
        vec!["run", "--out", out],
        vec!["run", "--out", out, "--resume"],
    ] {
        let summary = answer(swim_petsc(2, &task, &path, "off"));
        let found = summary["displacement"]["left"][0]
            .as_f64()
            .expect("a number");
        assert!(
            (found / expected - 1.0).abs() < AGREEMENT,
            "{found} {expected}"
        );
    }
    assert!(Path::new(out).join("summary.json").exists());
}
