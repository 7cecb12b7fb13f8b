//! Paths of joint values and forces on joints as functions of time.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use nalgebra::Vector3;
use swimmer::scene::{Gait, JointPath, OwnPath, Phase, ShapePath};
use swimmer::{Method, Outcome, Scene, choose, run, simulate};

fn simulated(scene: &Scene) -> Outcome {
    let mut model = choose(scene).unwrap().model;
    simulate(scene, model.as_mut(), Method::from_scene(scene), &mut ()).unwrap()
}

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

fn arms(gait: &str) -> Scene {
    let sphere = |name: &str, x: f64| {
        format!("[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = [{x:?}, 0, 0]\n")
    };
    let text = [
        "[model]\nkind = \"rpy\"\ntolerance = 1e-7\n".to_owned(),
        sphere("l", -6.0),
        sphere("c", 0.0),
        sphere("r", 7.0),
        "[[links]]\nname = \"left\"\nbody = \"l\"\nto = \"c\"\n".to_owned(),
        "[[links]]\nname = \"right\"\nbody = \"r\"\nto = \"c\"\n".to_owned(),
        gait.to_owned(),
    ];
    Scene::parse(&text.concat()).unwrap()
}

#[test]
fn a_path_of_a_program_moves_bodies_as_the_same_harmonics() {
    let harmonic = arms(&format!(
        "[gait]\nperiod = 3\n[[gait.harmonics]]\nlink = \"left\"\namplitude = 1\n\
         [[gait.harmonics]]\nlink = \"right\"\namplitude = 1\nphase = {:?}\n",
        0.5 * PI
    ));
    let path = ShapePath::Own(OwnPath(Arc::new(Oscillation)));
    let gait = Gait {
        cycles: 1,
        phases: vec![Phase {
            path,
            duration: 3.0,
        }],
    };
    let own = arms("").with_gait(gait).unwrap();
    let [expected, found] = [&harmonic, &own].map(simulated);
    let error = (expected.net() - found.net()).abs();
    assert!(
        expected.net() > 1e-3 && error < 1e-7 * expected.net(),
        "{error:e}"
    );
    assert!((expected.work - found.work).abs() < 1e-6 * expected.work);
    // Files cannot contain it, so runs that write them refuse it.
    let folder = tempfile::tempdir().unwrap();
    let error = run(own, folder.path(), false, &mut (), &mut ())
        .unwrap_err()
        .to_string();
    assert!(error.contains("path of a program"), "{error}");
}

/// Two equal spheres with a motor of this torque between them.
fn motor(force: &str, gait: &str) -> Scene {
    Scene::parse(&format!(
        "[model]\nkind = \"multipole\"\ntolerance = 1e-7\n\
         [[bodies]]\nname = \"head\"\nradius = 1\nposition = [0, 0, 0]\n\
         [[bodies]]\nname = \"tail\"\nradius = 1\nposition = [3, 0, 0]\n\
         [[links]]\nname = \"motor\"\nbody = \"tail\"\nto = \"head\"\njoint = \"rotor\"\n\
         drive = \"force\"\nforce = {force}\n{gait}"
    ))
    .unwrap()
}

/// `R dv/dt = m + A sin(ω t + φ)` with the resistance R of opposite rotations, which a constant
/// torque measures.
#[test]
fn an_oscillating_torque_turns_a_rotor_by_its_integral() {
    let turned = |force: &str, duration: f64| {
        let outcome = simulated(&motor(
            force,
            &format!("[[gait.phases]]\nduration = {duration:?}\n"),
        ));
        outcome.samples.last().unwrap().shape[0]
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
        let found = turned(&force, duration);
        assert!((found - exact).abs() < 1e-7, "{found} {exact}");
    }
}

#[test]
fn an_oscillating_force_keeps_its_keys_when_it_is_written() {
    let force = "{ amplitude = 2, period = 4 }";
    let scene = motor(force, "[[gait.phases]]\nduration = 1\n");
    assert_eq!(scene.joint_forces(1.0), Some(vec![2.0]));
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(again.joint_forces(1.0), Some(vec![2.0]));
    assert_eq!(scene.to_toml().unwrap(), again.to_toml().unwrap());
    for (force, problem) in [
        ("{ amplitude = 2 }", "has no period"),
        ("{ period = 2 }", "has no amplitude"),
        (
            "{ amplitude = 2, frequency = 3 }",
            "must be a number, or a table",
        ),
        (
            "{ amplitude = -2, period = 1 }",
            "must be a number, or a table",
        ),
    ] {
        let text = format!(
            "[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\n\
             [[bodies]]\nname = \"b\"\nradius = 1\nposition = [3, 0, 0]\n\
             [[links]]\nname = \"m\"\nbody = \"b\"\nto = \"a\"\njoint = \"rotor\"\n\
             drive = \"force\"\nforce = {force}\n"
        );
        let message = Scene::parse(&text).unwrap_err().to_string();
        assert!(message.contains(problem), "{message}");
    }
}

/// Bodies that are at rest but for an oscillating force return after its period.
#[test]
fn an_oscillating_force_on_an_arm_moves_it_to_and_fro() {
    let scene = Scene::parse(
        "[model]\nkind = \"rpy\"\ntolerance = 1e-6\n\
         [[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\n\
         [[bodies]]\nname = \"b\"\nradius = 1\nposition = [6, 0, 0]\n\
         [[links]]\nname = \"arm\"\nbody = \"b\"\nto = \"a\"\n\
         drive = \"force\"\nforce = { amplitude = 20, period = 2 }\n\
         [[gait.phases]]\nduration = 1\n[[gait.phases]]\nduration = 1\n",
    )
    .unwrap();
    let outcome = simulated(&scene);
    let shape: Vec<f64> = outcome.samples.iter().map(|s| s.shape[0]).collect();
    let longest = shape.iter().copied().fold(0.0, f64::max);
    assert!(longest > 6.5, "{longest}");
    assert!((shape.last().unwrap() - 6.0).abs() < 1e-6);
    assert!(outcome.displacement[0].norm() < 1e-6 && outcome.displacement[0] != Vector3::zeros());
}
