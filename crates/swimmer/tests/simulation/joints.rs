//! Joints that turn and passive joints, against exact values, with multipoles.

use std::f64::consts::{PI, TAU};

use nalgebra::{UnitQuaternion, Vector3};
use swimmer::{Method, Outcome};
use testkit::{SceneText, boxed, chain, run, run_by, three_spheres, within};

/// Displacement of the first body.
fn net(outcome: &Outcome) -> Vector3<f64> {
    outcome.displacement[0]
}

/// Two spheres of the radii 1 and 1/2 with this density relative to the fluid, whose distance
/// oscillates by 1 about `mean`.
fn dense_scallop(density: f64, mean: f64, amplitude: f64) -> SceneText {
    let body = |radius: f64| {
        let mass = density * 4.0 / 3.0 * PI * radius.powi(3);
        format!("radius = {radius:?}, mass = {mass:?}")
    };
    let text = SceneText::new().shape("large", &body(1.0), [0; 3]);
    let text = text
        .shape("small", &body(0.5), [mean, 0.0, 0.0])
        .slide("arm", "small", "large");
    let text = text.harmonics(1.0, &[("arm", amplitude, 0.0)]);
    text.with("gait.periodic", true).model("multipole", 1e-6)
}

/// Net displacement per period, toward the small sphere, of quasi-steady drag with masses: exact
/// multipoles, two integrators that agree in the digits given.
#[test]
#[ignore = "slow: 6 s"]
fn a_dense_scallop_moves_by_its_inertia() {
    for (mean, amplitude, density, net_exact) in [
        (4.0, 1.0, 0.01, 0.000_278_923_8),
        (4.0, 1.0, 0.1, 0.002_744_723_2),
        (4.0, 1.0, 10.0, 0.001_667_243_0),
        (10.0, 4.0, 0.1, 0.011_216_208_3),
    ] {
        let found = net(&run(&dense_scallop(density, mean, amplitude).scene())).x;
        let why = format!("ten tolerances, density {density}, mean {mean}");
        within(found - net_exact, 1e-5 * net_exact, why);
    }
}

/// Without mass the stages are those of the collocation of the massless motion.
#[test]
fn light_bodies_move_like_massless_ones() {
    let stroke = |mass: f64| {
        let text = (0..3).fold(three_spheres().tolerance(1e-6), |text, body| {
            text.with(&format!("bodies[{body}].mass"), format!("{mass:e}"))
        });
        net(&run(&text.scene())).x
    };
    let massless = stroke(0.0);
    let light = stroke(1e-9);
    let why = "a relaxation time of 1e-9 / (6 pi), times speeds of about one; and two tolerances";
    within(light - massless, 2e-6 * massless.abs(), why);
    // Displacements change in proportion to small masses.
    let [one, two] = [0.02, 0.04].map(|mass| stroke(mass) - massless);
    within(two / one - 2.0, 0.1, "the square of the mass");
}

/// Three spheres of which one arm oscillates and the other one is a spring, of stiffness 1.
fn elastic_arm(amplitude: f64, relative_frequency: f64) -> SceneText {
    // The frequency of the largest displacement is k / G22, to leading order.
    let frequency = 0.071_430_372_2 * relative_frequency;
    three_spheres()
        .without_phases()
        .set(&[
            "links[1].drive=spring",
            "links[1].stiffness=1",
            "gait.periodic=true",
        ])
        .harmonics(TAU / frequency, &[("left-arm", amplitude, 0.0)])
        .model("multipole", 1e-7)
}

/// Displacements per cycle of the periodic state, from exact multipoles and harmonic balance with
/// 64 points, for arms of 10 and the stiffness 1; towards the passive arm. Other frequencies are
/// rows of `cargo xtask validate`.
#[test]
fn an_elastic_arm_moves_as_its_periodic_state() {
    for (amplitude, frequency, displacement) in
        [(1.0, 1.0, 0.004_376_372_2), (4.0, 1.0, 0.074_714_864_8)]
    {
        let outcome = run(&elastic_arm(amplitude, frequency).scene());
        let why = format!("the tolerance, and the last of the digits; amplitude {amplitude}");
        let bound = 1e-7 * displacement + 1e-10;
        within(net(&outcome).x.abs() - displacement, bound, why);
        if (amplitude, frequency) == (1.0, 1.0) {
            within(outcome.work - 2.815_397_15, 1e-7, "the tolerance");
        }
    }
}

/// A rotor of two equal spheres turns each of them by half its angle, in opposite directions.
fn rotor(phase: &str, drive: &str) -> SceneText {
    let text = chain(&["head", "tail"], &[0.0, 3.0])
        .phase(phase)
        .model("multipole", 1e-7);
    text.joint(
        "motor",
        "tail",
        "head",
        &format!("joint = \"rotor\"{drive}"),
    )
}

#[test]
fn a_rotor_turns_equal_spheres_in_opposite_directions() {
    let angle = 2.5;
    let outcome = run(&rotor("link = \"motor\", length = 2.5", "").scene());
    let end = outcome.samples.last().unwrap();
    for (pose, half) in end.poses.iter().zip([-0.5, 0.5]) {
        let error = pose.rotation.scaled_axis() - half * angle * Vector3::<f64>::x();
        within(
            error.norm(),
            1e-9,
            "a hundredth of the tolerance: the rates are constant",
        );
    }
    assert!(outcome.displacement.iter().all(|d| d.norm() < 1e-12));
}

/// `dv/dt = -k v / R` with the resistance R of opposite rotations: the angle decays exponentially.
#[test]
fn a_twisted_rotor_relaxes_exponentially_at_any_stiffness() {
    let end = |stiffness: f64, duration: f64| {
        let drive = format!(", drive = \"spring\", stiffness = {stiffness:?}, rest = 1.0");
        let outcome = run(&rotor(&format!("duration = {duration:?}"), &drive).scene());
        outcome.samples.last().unwrap().shape[0]
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
            // Displacements of the surface are up to 1/2.
            let why = format!("the tolerance, and the resistance from 1e-4; {stiffness}");
            within(decayed - exact, 2e-6, why);
        }
    }
}

/// A scallop of one hinge, in any orientation, returns to where it started.
#[test]
fn a_scallop_of_one_hinge_goes_nowhere() {
    let text = SceneText::new()
        .sphere("left", 1.0, [-4, 0, 0])
        .sphere("right", 1.0, [4, 1, 0])
        .point("pivot", [0; 3])
        .slide("left", "left", "pivot")
        .joint(
            "hinge",
            "right",
            "pivot",
            "joint = \"hinge\", axis = [0.3, 0.2, 1]",
        )
        .phase("link = \"hinge\", length = 1.2, duration = 0.1")
        .phase("link = \"hinge\", length = 0, duration = 7");
    let outcome = run(&text.model("multipole", 1e-7).scene());
    let farthest = outcome
        .curve
        .iter()
        .map(|(_, x)| (x[0] - outcome.curve[0].1[0]).norm());
    assert!(farthest.fold(0.0, f64::max) > 0.1);
    let why = "the tolerance, relative to the displacement of a phase, of the order of 1";
    within(net(&outcome).norm(), 1e-7, why);
    within(outcome.rotation.norm(), 1e-7, why);
}

/// Joints that turn are given in any axes: a rotated swimmer moves along the rotated path.
#[test]
fn a_rotated_swimmer_with_hinges_moves_along_the_rotated_path() {
    let swimmer = |turn: &dyn Fn([f64; 3]) -> [f64; 3]| {
        let [hinge, pivot] = [[0.0, 0.0, 1.0], [-2.0, 0.0, 0.0]].map(turn);
        let rear = format!("joint = \"hinge\", axis = {hinge:?}, pivot = {pivot:?}");
        let axis = turn([0.0, 0.6, 0.8]);
        let front = format!("joint = \"screw\", axis = {axis:?}, pitch = 1.5");
        let text = SceneText::new()
            .sphere("tail", 1.0, turn([-4.0, 0.0, 0.0]))
            .sphere("middle", 1.0, turn([0.0; 3]))
            .sphere("head", 1.0, turn([4.0, 0.0, 0.0]))
            .joint("rear", "tail", "middle", &rear)
            .joint("front", "head", "middle", &front)
            .phase("targets = { rear = 0.8, front = -0.5 }")
            .phase("targets = { rear = -0.3, front = 0.7 }");
        run(&text.model("multipole", 1e-7).scene())
    };
    let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.7, -1.1, 0.4));
    let plain = swimmer(&|x| x);
    let turned = swimmer(&|x| (rotation * Vector3::from(x)).into());
    for (a, b) in plain.displacement.iter().zip(&turned.displacement) {
        assert!(a.norm() > 1e-2);
        within((rotation * a - b).norm(), 1e-6 * a.norm(), "ten tolerances");
    }
}

/// A passive ball passes no torque: the two halves of a dumb-bell under shear loads fold freely,
/// and the state with a ball continues from a checkpoint of its attitude.
#[test]
fn a_ball_lets_the_load_turn_its_body() {
    let text = chain(&["left", "right"], &[-2.0, 2.0]).phase("duration = 1");
    let text = text.joint(
        "ball",
        "right",
        "left",
        "joint = \"ball\", pivot = [0, 0, 0]",
    );
    let text = text
        .with("bodies.right.torque", "[0, 0, 20]")
        .model("multipole", 1e-7);
    let outcome = run(&text.scene());
    let end = outcome.samples.last().unwrap();
    let angle = |body: usize| end.poses[body].rotation.scaled_axis().z;
    let angles = [angle(0), angle(1)];
    assert!(angles[1] > 0.1 && angles[0] < 0.0, "{angles:?}");
    // Both stay at their distance from the ball.
    let pivot = |body: usize, arm: f64| {
        let pose = &end.poses[body];
        pose.translation.vector + pose.rotation * Vector3::new(arm, 0.0, 0.0)
    };
    let gap = (pivot(0, 2.0) - pivot(1, -2.0)).norm();
    within(gap, 1e-9, "joints stay closed to rounding");
}

#[test]
fn a_joint_without_a_spring_has_no_periodic_state() {
    // A constant force turns it for ever.
    let text = rotor("duration = 1", ", drive = \"force\", force = 1");
    let message = text.with("gait.periodic", true).refusal();
    testkit::contains("rotor", &message, &["gait.periodic", "motor"]);
}

/// A method without inertia ignores masses: their velocities are no part of its periodic state.
#[test]
fn the_periodic_state_of_a_massless_method_has_no_velocities() {
    let text = chain(&["left", "right"], &[-3.0, 3.0]).slide("arm", "right", "left");
    let text = text.set(&["bodies.left.mass=1e-9", "gait.periodic=true"]);
    let text = text
        .harmonics(1.0, &[("arm", 1.0, 0.0)])
        .model("multipole", 1e-7);
    let scene = text.scene();
    for method in [Method::Collocation, Method::BackwardEuler { steps: 4 }] {
        let net = run_by(boxed(&scene).as_mut(), method).displacement[0].norm();
        within(net, 1e-6, format!("ten tolerances; {method:?}"));
    }
}
