//! Paths of joint values and forces on joints as functions of time.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use nalgebra::Vector3;
use swimmer::Scene;
use swimmer::scene::{Gait, JointPath, OwnPath, Phase, ShapePath};
use testkit::{SceneText, chain, pair, run, within};

/// Two arms that oscillate about 6 with the amplitude 1, a quarter of a period apart.
#[derive(Debug)]
struct Oscillation;

impl JointPath for Oscillation {
    fn joints(&self) -> Vec<usize> {
        vec![0, 1]
    }

    fn values(&self, s: f64) -> Vec<f64> {
        vec![6.0 + (TAU * s).sin(), 6.0 + (TAU * s).cos()]
    }

    fn derivatives(&self, s: f64) -> Vec<f64> {
        vec![TAU * (TAU * s).cos(), -TAU * (TAU * s).sin()]
    }
}

fn arms() -> SceneText {
    let text = chain(&["l", "c", "r"], &[-6.0, 0.0, 7.0]).model("rpy", 1e-7);
    text.slide("left", "l", "c").slide("right", "r", "c")
}

#[test]
fn a_path_of_a_program_moves_bodies_as_the_same_harmonics() {
    let harmonic = arms()
        .harmonics(3.0, &[("left", 1.0, 0.0), ("right", 1.0, 0.5 * PI)])
        .scene();
    let path = ShapePath::Own(OwnPath(Arc::new(Oscillation)));
    let gait = Gait {
        cycles: 1,
        phases: vec![Phase {
            path,
            duration: 3.0,
        }],
    };
    let own = arms().scene().with_gait(gait).unwrap();
    let [expected, found] = [&harmonic, &own].map(run);
    assert!(expected.net() > 1e-3);
    within(
        expected.net() - found.net(),
        1e-7 * expected.net(),
        "the tolerance",
    );
    within(
        expected.work - found.work,
        1e-6 * expected.work,
        "the tolerance of displacements",
    );
    // Files cannot contain it, so runs that write them refuse it.
    let folder = tempfile::tempdir().unwrap();
    let error = swimmer::run(own, folder.path(), false, &mut (), &mut ()).unwrap_err();
    testkit::contains("own path", &error.to_string(), &["path of a program"]);
}

/// Two equal spheres with a motor of this torque between them, for a duration.
fn motor(force: &str, duration: f64) -> SceneText {
    let keys = format!("joint = \"rotor\", drive = \"force\", force = {force}");
    let text = chain(&["head", "tail"], &[0.0, 3.0]).joint("motor", "tail", "head", &keys);
    text.phase(&format!("duration = {duration:?}"))
        .model("multipole", 1e-7)
}

/// `R dv/dt = m + A sin(ω t + φ)` with the resistance R of opposite rotations, which a constant
/// torque measures.
#[test]
fn an_oscillating_torque_turns_a_rotor_by_its_integral() {
    let turned = |force: &str, duration: f64| {
        run(&motor(force, duration).scene())
            .samples
            .last()
            .unwrap()
            .shape[0]
    };
    let resistance = 1.0 / turned("1.0", 1.0);
    let (mean, amplitude, phase, period) = (0.5, 4.0, 0.7_f64, 2.0);
    let force = format!(
        "{{ mean = {mean:?}, amplitude = {amplitude:?}, phase = {phase:?}, order = 3, period = {period:?} }}"
    );
    let omega = 3.0 * TAU / period;
    for duration in [0.3_f64, 1.7] {
        let oscillating = (phase.cos() - (omega * duration + phase).cos()) / omega;
        let exact = (mean * duration + amplitude * oscillating) / resistance;
        within(turned(&force, duration) - exact, 1e-7, "the tolerance");
    }
}

#[test]
fn an_oscillating_force_keeps_its_keys_when_it_is_written() {
    let force = "{ amplitude = 2, period = 4 }";
    let scene = motor(force, 1.0).scene();
    assert_eq!(scene.joint_forces(1.0), Some(vec![2.0]));
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(again.joint_forces(1.0), Some(vec![2.0]));
    assert_eq!(scene.to_toml().unwrap(), again.to_toml().unwrap());
    let form = "must be a number, or a table";
    for (force, problem) in [
        ("{ amplitude = 2 }", "has no period"),
        ("{ period = 2 }", "has no amplitude"),
        ("{ amplitude = 2, frequency = 3 }", form),
        ("{ amplitude = -2, period = 1 }", form),
    ] {
        testkit::contains(force, &motor(force, 1.0).refusal(), &[problem]);
    }
}

/// Bodies that are at rest but for an oscillating force return after its period.
#[test]
fn an_oscillating_force_on_an_arm_moves_it_to_and_fro() {
    let text = pair(0.0, 6.0)
        .phase("duration = 1")
        .phase("duration = 1")
        .model("rpy", 1e-6);
    let force = [
        "links.arm.drive=force",
        "links.arm.force={ amplitude = 20, period = 2 }",
    ];
    let outcome = run(&text.set(&force).scene());
    let shape: Vec<f64> = outcome.samples.iter().map(|s| s.shape[0]).collect();
    let longest = shape.iter().copied().fold(0.0, f64::max);
    assert!(longest > 6.5, "{longest}");
    within(shape.last().unwrap() - 6.0, 1e-6, "the tolerance");
    within(outcome.displacement[0].norm(), 1e-6, "the tolerance");
    assert!(outcome.displacement[0] != Vector3::zeros());
}
