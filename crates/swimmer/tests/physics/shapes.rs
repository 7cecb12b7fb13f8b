//! Bodies of any shape: exact drag and torque, bars, orientations.

use std::f64::consts::PI;
use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use swimmer::models::{Configuration, FemModel, Hydrodynamics, InstantaneousSolution, Resistances};
use swimmer::{Outcome, Scene};
use testkit::exact::{BODIES, Body};
use testkit::{SceneText, boxed, forces, run, start, start_by, within};

/// A body in unbounded fluid, turned by `orientation`, under a force and a torque.
fn loaded(
    shape: &str,
    orientation: Vector3<f64>,
    loads: [Vector3<f64>; 2],
    settings: &[&str],
) -> Scene {
    let text = SceneText::new().shape("b", shape, [0.5, 1.0, -2.0]);
    let keys = ["orientation", "force", "torque"];
    let vectors = [orientation, loads[0], loads[1]];
    let text = vectors.iter().zip(keys).fold(text, |text, (vector, key)| {
        text.with(
            &format!("bodies.b.{key}"),
            format!("{:?}", vector.as_slice()),
        )
    });
    text.with("model.kind", "fem").set(settings).scene()
}

/// Asserts that the velocities of a body turned off all axes are within the bar of the velocity,
/// and within 1e-3, for loads along all of its axes at once.
fn assert_exact(exact: &Body, size: &str) -> InstantaneousSolution {
    let orientation = Vector3::new(0.4, -0.7, 1.0);
    let turn = UnitQuaternion::from_scaled_axis(orientation);
    let loads = [6.0 * PI, 8.0 * PI].map(|load| turn * Vector3::repeat(load));
    let instant = start(&loaded(exact.keys, orientation, loads, &[size]));
    let body = &instant.bodies[0];
    let [linear, angular] = [body.velocity, body.angular_velocity].map(|v| turn.inverse() * v);
    let bar = instant.error_estimate.total();
    for axis in 0..3 {
        let error = linear[axis] * exact.drag[axis] - 1.0;
        let allowed = bar * exact.drag[axis] + exact.accuracy;
        let what = format!("{} axis {axis}", exact.keys);
        within(error, allowed, format!("bar and digits: {what}"));
        within(error, 1e-3, format!("the default accuracy: {what}"));
        within(
            angular[axis] * exact.torque[axis] - 1.0,
            1e-3,
            format!("of torques: {what}"),
        );
    }
    instant
}

/// The coarsest mesh; two seconds because the ball that replaces unbounded fluid is large.
#[test]
fn a_turned_prolate_spheroid_and_a_capsule_have_the_exact_drag() {
    for exact in &BODIES[..2] {
        let instant = assert_exact(exact, COARSE_SETTINGS);
        assert!(instant.dofs.total < 60_000, "{}", instant.dofs.total);
    }
}

#[test]
#[ignore = "slow: 40 s"]
fn drag_and_torque_of_all_shapes_with_exact_values() {
    for exact in &BODIES {
        for size in [COARSE_SETTINGS, "fem.size_factor=1.0"] {
            assert_exact(exact, size);
        }
    }
}

const COARSE_SETTINGS: &str = "fem.size_factor=1.75";

const SHAPES: [&str; 6] = [
    "shape = \"ellipsoid\", semi_axes = [1.5, 0.7, 1]",
    "shape = \"spheroid\", radius = 1, half_length = 0.6",
    "shape = \"capsule\", radius = 0.6, half_length = 1.5",
    "shape = \"disk\", radius = 1, half_length = 0.3",
    "shape = \"torus\", radius = 1, tube_radius = 0.4",
    "shape = \"helix\", radius = 0.6, tube_radius = 0.25, pitch = 1.2, turns = 1.4",
];

const SMALL_DOMAIN: [&str; 2] = ["domain={ kind = \"ball\", radius = 8 }", COARSE_SETTINGS];

#[test]
#[ignore = "slow: 30 s"]
fn resistances_of_all_shapes_are_symmetric_and_positive_definite() {
    for name in SHAPES {
        let turned = Vector3::new(10.0, 30.0, -50.0);
        let scene = loaded(name, turned, [Vector3::x(); 2], &SMALL_DOMAIN);
        let (state, shape) = (&scene.initial_state(), &[]);
        let mut model = FemModel::new(&scene).expect("a model");
        let resistance = model.resistance(Configuration::new(state, shape));
        let resistance = resistance.expect("a resistance").matrix;
        let asymmetry = (&resistance - resistance.transpose()).amax() / resistance.amax();
        within(
            asymmetry,
            1e-5,
            format!("six solves to 1e-8, and corrections: {name}"),
        );
        let smallest = resistance.symmetric_eigenvalues().min();
        assert!(smallest > 0.0, "{name}: {smallest}");
    }
}

/// Velocities in the frame of the body, and their bar.
fn own_motion(shape: &str, orientation: Vector3<f64>) -> ([Vector3<f64>; 2], f64) {
    let turn = UnitQuaternion::from_scaled_axis(orientation);
    let loads = [Vector3::new(3.0, -2.0, 5.0), Vector3::new(-4.0, 1.0, 2.0)];
    // Unbounded fluid has no frame.
    let loads = loads.map(|load| turn * load);
    let instant = start(&loaded(shape, orientation, loads, &[COARSE_SETTINGS]));
    let body = &instant.bodies[0];
    let motion = [body.velocity, body.angular_velocity].map(|v| turn.inverse() * v);
    (motion, instant.error_estimate.total())
}

fn assert_indifferent(shape: &str, orientation: Vector3<f64>) {
    let ([u, w], bar) = own_motion(shape, Vector3::zeros());
    let ([turned_u, turned_w], turned_bar) = own_motion(shape, orientation);
    let what = format!("{shape} {orientation}");
    within(
        (turned_u - u).norm(),
        bar + turned_bar,
        format!("both error bars: {what}"),
    );
    // The bar is that of velocities; angular velocities have about the same relative accuracy.
    within(
        (turned_w - w).norm(),
        4e-3 * w.norm(),
        format!("accuracy of velocities: {what}"),
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, ..ProptestConfig::default() })]
    #[test]
    #[ignore = "slow: 40 s"]
    fn motions_do_not_depend_on_the_frame(
        shape in 0..SHAPES.len(), turn in prop::array::uniform3(-1.8..1.8_f64),
    ) {
        assert_indifferent(SHAPES[shape], turn.into());
    }
}

/// The mesh turns with the body: the answer on the turned mesh is that on a new one.
#[test]
fn meshes_turn_with_the_bodies() {
    let loads = [Vector3::new(3.0, -2.0, 5.0), Vector3::new(-4.0, 1.0, 2.0)];
    let scene = loaded(SHAPES[0], Vector3::zeros(), loads, &SMALL_DOMAIN);
    let mut state = scene.initial_state();
    let mut model = FemModel::new(&scene).expect("a model");
    let mut at = |model: &mut FemModel, angle: f64| {
        let turn = UnitQuaternion::from_scaled_axis(angle * Vector3::new(0.6, 0.0, 0.8));
        state.attitudes[0] = turn;
        let poses = scene.articulation().place(&state, &[]).expect("poses");
        within(poses[0].rotation.angle_to(&turn), 1e-12, "rounding");
        let configuration = testkit::at(&state, &[]);
        model.solve_one(configuration, &[]).expect("a solution")
    };
    at(&mut model, 0.0);
    let moved = at(&mut model, 0.2);
    assert!(moved.remeshed.is_none(), "{:?}", moved.remeshed);
    let new = at(&mut FemModel::new(&scene).expect("a model"), 0.2);
    let [a, b] = [&moved, &new].map(|s| s.bodies[0].velocity);
    let bars = moved.error_estimate.total() + new.error_estimate.total();
    within((a - b).norm(), bars, "both error bars");
}

/// A helix under a torque along its axis moves along it, in the direction of its hand.
#[test]
#[ignore = "slow: 10 s"]
fn a_right_handed_helix_moves_forward_when_it_turns_right() {
    let motion = |pitch: f64, size: f64| {
        let shape = format!(
            "shape = \"helix\", radius = 0.6, tube_radius = 0.2, pitch = {pitch:?}, turns = 2"
        );
        let loads = [Vector3::zeros(), Vector3::x()];
        let size = format!("fem.size_factor={size:?}");
        let instant = start(&loaded(&shape, Vector3::zeros(), loads, &[&size]));
        (instant.bodies[0].velocity.x, instant.error_estimate.total())
    };
    let (right, bar) = motion(1.5, 1.75);
    let (left, _) = motion(-1.5, 1.75);
    let (finer, finer_bar) = motion(1.5, 1.0);
    // A corkscrew: torque and spin along +x push a right-handed helix along +x.
    assert!(right > 10.0 * bar, "{right} {bar}");
    within(right + left, 2.0 * bar, "both error bars");
    within(right - finer, bar + finer_bar, "both error bars");
}

/// The scene of three capsules end to end runs with its forces in balance.
#[test]
#[ignore = "slow: 40 s"]
fn the_capsule_swimmer_swims() {
    let scene = of_gallery("capsule-swimmer.toml");
    let mut model = boxed(&scene);
    assert_eq!(model.name(), "fem");
    let (force, largest) = forces(&start_by(model.as_mut()));
    within(force.norm(), 1e-6 * largest, "the residual of the solver");
    let outcome = swimmer::simulate(
        &scene,
        model.as_mut(),
        swimmer::Method::Collocation,
        &mut (),
    );
    let why = "a bar of 0.000070; without an exact value this keeps the answer where it was";
    within(outcome.expect("a run").net() - 0.092721, 3e-4, why);
}

/// The scene of the gallery with this name.
fn of_gallery(name: &str) -> Scene {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    Scene::read(folder.join(name), &[]).expect("a scene of the gallery")
}

fn run_of_gallery(name: &str) -> Outcome {
    run(&of_gallery(name))
}

/// The bar is 0.00024; without an exact value these numbers keep the answer where it was computed.
#[test]
#[ignore = "slow: 16 s"]
fn the_swimmer_in_a_bent_channel_swims_and_turns() {
    let outcome = run_of_gallery("bent-channel.toml");
    within(outcome.net() - 0.04202, 5e-4, "two error bars");
    within(
        outcome.rotation.z + 9.6e-4,
        2e-4,
        "the error bar, over arms of about one",
    );
    within(
        outcome.rotation.xy().norm(),
        2e-4,
        "the error bar, over arms of about one",
    );
}

/// It falls between the spheres and makes about half a turn.
#[test]
#[ignore = "slow: 10 s"]
fn the_ellipsoid_between_two_fixed_spheres_tumbles() {
    let outcome = run_of_gallery("tumbling-ellipsoid.toml");
    within(
        outcome.net() - 1.1293,
        8e-3,
        "the error bar: keeps the answer where it was",
    );
    within(outcome.rotation.z - 2.982, 2e-2, "the same for rotations");
    within(
        outcome.rotation.xy().norm(),
        1e-2,
        "the scene is symmetric, its mesh is not",
    );
}
