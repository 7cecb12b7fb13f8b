//! Joints that turn and passive joints, against exact values, with multipoles.

use std::f64::consts::{PI, TAU};

use crate::strokes::FREE;
use crate::support::three_spheres;
use nalgebra::Vector3;
use swimmer::{Method, Outcome, Scene, choose, simulate};

/// Runs the gait, from the periodic state if the scene says so.
fn run(text: &str) -> Outcome {
    let scene = Scene::parse(text).unwrap();
    let mut model = choose(&scene).unwrap().model;
    let method = Method::from_scene(&scene);
    simulate(&scene, model.as_mut(), method, &mut ()).unwrap()
}

/// Displacement of the first body.
fn net(outcome: &Outcome) -> Vector3<f64> {
    outcome.displacement[0]
}

/// Two spheres of the radii 1 and 1/2 with this density relative to the fluid, whose distance
/// oscillates by 1 about `mean`.
fn dense_scallop(density: f64, mean: f64, amplitude: f64) -> String {
    let body = |name: &str, radius: f64, x: f64| {
        let mass = density * 4.0 / 3.0 * PI * radius.powi(3);
        format!(
            "[[bodies]]\nname = \"{name}\"\nradius = {radius:?}\nposition = [{x:?}, 0, 0]\n\
             mass = {mass:?}\n"
        )
    };
    [
        body("large", 1.0, 0.0),
        body("small", 0.5, mean),
        "[[links]]\nname = \"arm\"\nbody = \"small\"\nto = \"large\"\n".to_owned(),
        format!(
            "[gait]\nperiodic = true\nperiod = 1\n\
             [[gait.harmonics]]\nlink = \"arm\"\namplitude = {amplitude:?}\n"
        ),
        "[model]\nkind = \"multipole\"\ntolerance = 1e-6\n".to_owned(),
    ]
    .concat()
}

/// Net displacement per period, toward the small sphere, of quasi-steady drag with masses: exact
/// multipoles, two integrators that agree in the digits given.
#[test]
fn a_dense_scallop_moves_by_its_inertia() {
    for (mean, amplitude, density, net_exact) in [
        (4.0, 1.0, 0.01, 0.000_278_923_8),
        (4.0, 1.0, 0.1, 0.002_744_723_2),
        (4.0, 1.0, 10.0, 0.001_667_243_0),
        (10.0, 4.0, 0.1, 0.011_216_208_3),
    ] {
        let outcome = run(&dense_scallop(density, mean, amplitude));
        let error = (net(&outcome).x - net_exact).abs();
        assert!(
            error < 1e-5 * net_exact,
            "{density} {mean}: {} instead of {net_exact}",
            net(&outcome).x
        );
    }
}

/// Without mass the stages are those of the collocation of the massless motion.
#[test]
fn light_bodies_move_like_massless_ones() {
    let stroke = |mass: f64| {
        let mut text = three_spheres("model.tolerance = 1e-6", FREE);
        if mass > 0.0 {
            text = text.replace("radius = 1\n", &format!("radius = 1\nmass = {mass:e}\n"));
            assert_eq!(text.matches("mass").count(), 3);
        }
        net(&run(&text)).x
    };
    let massless = stroke(0.0);
    // A relaxation time of 1e-9 / (6 pi), times speeds of about one.
    let light = stroke(1e-9);
    assert!(
        (light - massless).abs() < 2e-6 * massless.abs(),
        "{light} {massless}"
    );
    // Displacements change in proportion to small masses.
    let [one, two] = [0.02, 0.04].map(|mass| stroke(mass) - massless);
    assert!((two / one - 2.0).abs() < 0.1, "{one} {two}");
}

fn sphere(name: &str, position: [f64; 3]) -> String {
    format!("[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = {position:?}\n")
}

const MULTIPOLES: &str = "[model]\nkind = \"multipole\"\ntolerance = 1e-7\n";

/// Three spheres of which one arm oscillates and the other one is a spring, of stiffness 1.
fn elastic_arm(amplitude: f64, relative_frequency: f64) -> String {
    // The frequency of the largest displacement is k / G22, to leading order.
    let frequency = 0.071_430_372_2 * relative_frequency;
    [
        sphere("left", [-10.0, 0.0, 0.0]),
        sphere("middle", [0.0; 3]),
        sphere("right", [10.0, 0.0, 0.0]),
        "[[links]]\nname = \"driven\"\nbody = \"left\"\nto = \"middle\"\n\
         [[links]]\nname = \"elastic\"\nbody = \"right\"\nto = \"middle\"\n\
         drive = \"spring\"\nstiffness = 1\n"
            .to_owned(),
        format!(
            "[gait]\nperiodic = true\nperiod = {:?}\n\
             [[gait.harmonics]]\nlink = \"driven\"\namplitude = {amplitude}\n",
            TAU / frequency
        ),
        MULTIPOLES.to_owned(),
    ]
    .concat()
}

/// Displacements per cycle of the periodic state, from exact multipoles and harmonic balance with
/// 64 points, for arms of 10 and the stiffness 1; towards the passive arm. Other frequencies are
/// rows of `cargo xtask validate`.
#[test]
fn an_elastic_arm_moves_as_its_periodic_state() {
    for (amplitude, frequency, displacement) in
        [(1.0, 1.0, 0.004_376_372_2), (4.0, 1.0, 0.074_714_864_8)]
    {
        let outcome = run(&elastic_arm(amplitude, frequency));
        let net = net(&outcome);
        // The tolerance, and the last of the digits given.
        let allowed = 1e-7 * displacement + 1e-10;
        let error = (net.x.abs() - displacement).abs();
        assert!(
            error < allowed,
            "{amplitude} {frequency}: {} {error:e}",
            net.x
        );
        if (amplitude, frequency) == (1.0, 1.0) {
            assert!(
                (outcome.work - 2.815_397_15).abs() < 1e-7,
                "{}",
                outcome.work
            );
        }
    }
}

/// A rotor of two equal spheres turns each of them by half its angle, in opposite directions.
fn rotor(gait: &str, drive: &str) -> String {
    [
        sphere("head", [0.0; 3]),
        sphere("tail", [3.0, 0.0, 0.0]),
        format!("[[links]]\nname = \"motor\"\nbody = \"tail\"\nto = \"head\"\njoint = \"rotor\"\n{drive}"),
        gait.to_owned(),
        MULTIPOLES.to_owned(),
    ]
    .concat()
}

#[test]
fn a_rotor_turns_equal_spheres_in_opposite_directions() {
    let angle = 2.5;
    let outcome = run(&rotor(
        "[[gait.phases]]\nlink = \"motor\"\nlength = 2.5\n",
        "",
    ));
    let end = outcome.samples.last().unwrap();
    for (pose, half) in end.poses.iter().zip([-0.5, 0.5]) {
        let rotation = pose.rotation.scaled_axis();
        assert!(
            (rotation - half * angle * Vector3::<f64>::x()).norm() < 1e-9,
            "{rotation}"
        );
    }
    assert!(outcome.displacement.iter().all(|d| d.norm() < 1e-12));
}

/// `dv/dt = -k v / R` with the resistance R of opposite rotations: the angle decays exponentially.
#[test]
fn a_twisted_rotor_relaxes_exponentially_at_any_stiffness() {
    let end = |stiffness: f64, duration: f64| {
        let drive = format!("drive = \"spring\"\nstiffness = {stiffness:?}\nrest = 1.0\n");
        let gait = format!("[[gait.phases]]\nduration = {duration:?}\n");
        *run(&rotor(&gait, &drive))
            .samples
            .last()
            .unwrap()
            .shape
            .first()
            .unwrap()
    };
    // The resistance from the initial rate: 4 pi mu a^3 for spheres far apart, larger for near
    // ones.
    let short = 1e-4;
    let resistance = short / -(1.0 - end(1.0, short)).ln();
    assert!(
        (1.0..1.1).contains(&(resistance / (4.0 * PI))),
        "{resistance}"
    );
    for stiffness in [1e-6, 1e-2, 1.0, 30.0] {
        for relaxation_times in [0.1, 1.0, 4.0] {
            let decayed = end(stiffness, relaxation_times * resistance / stiffness);
            let exact = 1.0 - (-relaxation_times).exp();
            // The tolerance of 1e-7 with displacements of the surface of up to 1/2, and the error
            // of the resistance from a difference over 1e-4.
            assert!(
                (decayed - exact).abs() < 2e-6,
                "{stiffness}: {decayed} {exact}"
            );
        }
    }
}

/// A scallop of one hinge, in any orientation, returns to where it started.
#[test]
fn a_scallop_of_one_hinge_goes_nowhere() {
    let scallop = [
        sphere("left", [-4.0, 0.0, 0.0]),
        sphere("right", [4.0, 1.0, 0.0]),
        "[[bodies]]\nname = \"pivot\"\nshape = \"point\"\nposition = [0, 0, 0]\n\
         [[links]]\nname = \"left\"\nbody = \"left\"\nto = \"pivot\"\n\
         [[links]]\nname = \"hinge\"\nbody = \"right\"\nto = \"pivot\"\njoint = \"hinge\"\n\
         axis = [0.3, 0.2, 1]\n"
            .to_owned(),
        "[[gait.phases]]\nlink = \"hinge\"\nlength = 1.2\nduration = 0.1\n\
         [[gait.phases]]\nlink = \"hinge\"\nlength = 0\nduration = 7\n"
            .to_owned(),
        MULTIPOLES.to_owned(),
    ]
    .concat();
    let outcome = run(&scallop);
    let farthest = outcome
        .curve
        .iter()
        .map(|(_, x)| (x[0] - outcome.curve[0].1[0]).norm());
    assert!(farthest.fold(0.0, f64::max) > 0.1);
    // The tolerance is relative to the displacement of a phase, of the order of 1.
    assert!(net(&outcome).norm() < 1e-7, "{}", net(&outcome));
    assert!(outcome.rotation.norm() < 1e-7, "{}", outcome.rotation);
}

/// Joints that turn are given in any axes: a rotated swimmer moves along the rotated path.
#[test]
fn a_rotated_swimmer_with_hinges_moves_along_the_rotated_path() {
    let swimmer = |turn: &dyn Fn([f64; 3]) -> [f64; 3]| {
        [
            sphere("tail", turn([-4.0, 0.0, 0.0])),
            sphere("middle", turn([0.0; 3])),
            sphere("head", turn([4.0, 0.0, 0.0])),
            format!(
                "[[links]]\nname = \"rear\"\nbody = \"tail\"\nto = \"middle\"\njoint = \"hinge\"\n\
                 axis = {:?}\npivot = {:?}\n\
                 [[links]]\nname = \"front\"\nbody = \"head\"\nto = \"middle\"\njoint = \"screw\"\n\
                 axis = {:?}\npitch = 1.5\n",
                turn([0.0, 0.0, 1.0]),
                turn([-2.0, 0.0, 0.0]),
                turn([0.0, 0.6, 0.8]),
            ),
            "[[gait.phases]]\ntargets = { rear = 0.8, front = -0.5 }\n\
             [[gait.phases]]\ntargets = { rear = -0.3, front = 0.7 }\n"
                .to_owned(),
            MULTIPOLES.to_owned(),
        ]
        .concat()
    };
    let rotation = nalgebra::UnitQuaternion::from_scaled_axis(Vector3::new(0.7, -1.1, 0.4));
    let plain = run(&swimmer(&|x| x));
    let turned = run(&swimmer(&|x| (rotation * Vector3::from(x)).into()));
    for (a, b) in plain.displacement.iter().zip(&turned.displacement) {
        assert!(a.norm() > 1e-2);
        assert!((rotation * a - b).norm() < 1e-6 * a.norm(), "{a} {b}");
    }
}

/// A passive ball passes no torque: the two halves of a dumb-bell under shear loads fold freely,
/// and the state with a ball continues from a checkpoint of its attitude.
#[test]
fn a_ball_lets_the_load_turn_its_body() {
    let text = [
        sphere("left", [-2.0, 0.0, 0.0]),
        sphere("right", [2.0, 0.0, 0.0]),
        "torque = [0, 0, 20]\n".to_owned(),
        "[[links]]\nname = \"ball\"\nbody = \"right\"\nto = \"left\"\njoint = \"ball\"\n\
         pivot = [0, 0, 0]\n[[gait.phases]]\nduration = 1\n"
            .to_owned(),
        MULTIPOLES.to_owned(),
    ]
    .concat();
    let outcome = run(&text);
    let end = outcome.samples.last().unwrap();
    let angle = |body: usize| end.poses[body].rotation.scaled_axis().z;
    assert!(
        angle(1) > 0.1 && angle(0) < 0.0,
        "{} {}",
        angle(0),
        angle(1)
    );
    // Both stay at their distance from the ball.
    let pivot = |body: usize, arm: f64| {
        let pose = &end.poses[body];
        pose.translation.vector + pose.rotation * Vector3::new(arm, 0.0, 0.0)
    };
    assert!((pivot(0, 2.0) - pivot(1, -2.0)).norm() < 1e-9);
}

#[test]
fn a_joint_without_a_spring_has_no_periodic_state() {
    // A constant force turns it for ever.
    let text = rotor(
        "[gait]\nperiodic = true\n[[gait.phases]]\nduration = 1\n",
        "drive = \"force\"\nforce = 1\n",
    );
    let message = Scene::parse(&text).unwrap_err().to_string();
    assert!(
        message.contains("gait.periodic") && message.contains("motor"),
        "{message}"
    );
}

/// A method without inertia ignores masses: their velocities are no part of its periodic state.
#[test]
fn the_periodic_state_of_a_massless_method_has_no_velocities() {
    let text = format!(
        "{}mass = 1e-9\n{}",
        sphere("left", [-3.0, 0.0, 0.0]),
        [
            sphere("right", [3.0, 0.0, 0.0]),
            "[[links]]\nname = \"arm\"\nbody = \"right\"\nto = \"left\"\n[gait]\nperiodic = true\n\
             period = 1\n[[gait.harmonics]]\nlink = \"arm\"\namplitude = 1\n"
                .to_owned(),
            MULTIPOLES.to_owned(),
        ]
        .concat()
    );
    let scene = Scene::parse(&text).unwrap();
    let net = |method| {
        let mut model = choose(&scene).unwrap().model;
        let outcome = simulate(&scene, model.as_mut(), method, &mut ()).unwrap();
        outcome.displacement[0].norm()
    };
    for method in [Method::Collocation, Method::BackwardEuler { steps: 4 }] {
        assert!(net(method) < 1e-6, "{method:?}");
    }
}
