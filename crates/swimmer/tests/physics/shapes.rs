//! Bodies of any shape: exact drag and torque, bars, orientations.
//!
//! Exact values of ellipsoids: Oberbeck 1876 and Jeffery 1922, `F_i = 16 pi U_i / (chi + a_i^2
//! alpha_i)` and `T_1 = 16 pi (b^2 + c^2) omega_1 / (3 (b^2 beta + c^2 gamma))` with Carlson's
//! integrals `chi = 2 RF`, `alpha = 2/3 RD`. Those of capsules (4 to 5 digits): ring Stokeslets on
//! the surface, which meet the values of spheroids to 1e-9.

use std::f64::consts::PI;
use std::path::Path;

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use swimmer::models::{Configuration, FemModel, Hydrodynamics, InstantaneousSolution, Resistances};
use swimmer::{Method, Outcome, Scene, choose, simulate, solve_start};

use super::scenes::{parse, solve};

/// A body with its drags over `6 pi` and torques over `8 pi` along its own axes.
struct Exact {
    shape: &'static str,
    drag: [f64; 3],
    torque: [f64; 3],
    /// Relative accuracy of these values.
    digits: f64,
}

const PROLATE: Exact = Exact {
    shape: "shape = \"ellipsoid\", semi_axes = [2, 1, 1]",
    drag: [1.2039409898, 1.3788990569, 1.3788990569],
    torque: [1.6133533986, 3.0098524745, 3.0098524745],
    digits: 1e-9,
};

const SLENDER: Exact = Exact {
    shape: "shape = \"spheroid\", radius = 1, half_length = 10",
    drag: [2.6471360019, 3.8115284451, 3.8115284451],
    torque: [6.8047061205, 133.6803680980, 133.6803680980],
    digits: 1e-9,
};

const OBLATE: Exact = Exact {
    shape: "shape = \"spheroid\", radius = 1, half_length = 0.5",
    drag: [0.9053052615, 0.7927074276, 0.7927074276],
    torque: [0.7050201619, 0.5658157884, 0.5658157884],
    digits: 1e-9,
};

const TRIAXIAL: Exact = Exact {
    shape: "shape = \"ellipsoid\", semi_axes = [3, 2, 1]",
    drag: [1.7942956646, 1.9415195515, 2.2048206919],
    torque: [6.0784308862, 10.0844494468, 10.5036820535],
    digits: 1e-9,
};

const CAPSULE_2: Exact = Exact {
    shape: "shape = \"capsule\", radius = 1, half_length = 2",
    drag: [1.3153, 1.48523, 1.48523],
    torque: [2.0552, 3.7799, 3.7799],
    digits: 2e-4,
};

const CAPSULE_3: Exact = Exact {
    shape: "shape = \"capsule\", radius = 1, half_length = 3",
    drag: [1.5783, 1.89624, 1.89624],
    torque: [3.0733, 9.2924, 9.2924],
    digits: 2e-4,
};

const CAPSULE_10: Exact = Exact {
    shape: "shape = \"capsule\", radius = 1, half_length = 10",
    drag: [3.023, 4.2058, 4.2058],
    torque: [10.100, 176.14, 176.14],
    digits: 1e-3,
};

/// A body in unbounded fluid, turned by `orientation`, under a force and a torque.
fn loaded(
    shape: &str,
    orientation: Vector3<f64>,
    [force, torque]: [Vector3<f64>; 2],
    options: &str,
) -> Scene {
    let list = |v: Vector3<f64>| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z);
    parse(&format!(
        "model.kind = \"fem\"\n{options}\nbodies = [{{ name = \"b\", {shape}, position = [0.5, 1, -2], \
         orientation = {}, force = {}, torque = {} }}]",
        list(orientation),
        list(force),
        list(torque)
    ))
}

/// Asserts that the velocities of a body turned off all axes are within the bar of the velocity,
/// and within 1e-3, for loads along all of its axes at once.
fn assert_exact(exact: &Exact, options: &str) -> InstantaneousSolution {
    let orientation = Vector3::new(0.4, -0.7, 1.0);
    let turn = UnitQuaternion::from_scaled_axis(orientation);
    let loads = [
        6.0 * PI * Vector3::repeat(1.0),
        8.0 * PI * Vector3::repeat(1.0),
    ];
    let own = loads.map(|load| turn * load);
    let instant = solve(&loaded(exact.shape, orientation, own, options));
    let body = &instant.bodies[0];
    let linear = turn.inverse() * body.velocity;
    let angular = turn.inverse() * body.angular_velocity;
    let bar = instant.error_estimate.total();
    for axis in 0..3 {
        let [u, w] = [
            linear[axis] * exact.drag[axis],
            angular[axis] * exact.torque[axis],
        ];
        let allowed = bar * exact.drag[axis] + exact.digits;
        let what = format!("{} axis {axis}: {u} {w} {allowed:.1e}", exact.shape);
        assert!(
            (u - 1.0).abs() <= allowed && (u - 1.0).abs() < 1e-3,
            "{what}"
        );
        assert!((w - 1.0).abs() < 1e-3, "{what}");
    }
    instant
}

/// The coarsest mesh; two seconds because the ball that replaces unbounded fluid is large.
#[test]
fn a_turned_prolate_spheroid_and_a_capsule_have_the_exact_drag() {
    for exact in [&PROLATE, &CAPSULE_2] {
        let instant = assert_exact(exact, "fem.size_factor = 1.75");
        assert!(instant.dofs.total < 60_000, "{}", instant.dofs.total);
    }
}

#[test]
#[ignore = "slow: 40 s"]
fn drag_and_torque_of_all_shapes_with_exact_values() {
    for exact in [
        &PROLATE,
        &SLENDER,
        &OBLATE,
        &TRIAXIAL,
        &CAPSULE_2,
        &CAPSULE_3,
        &CAPSULE_10,
    ] {
        for size in [1.75, 1.0] {
            assert_exact(exact, &format!("fem.size_factor = {size}"));
        }
    }
}

const SHAPES: [&str; 6] = [
    "shape = \"ellipsoid\", semi_axes = [1.5, 0.7, 1]",
    "shape = \"spheroid\", radius = 1, half_length = 0.6",
    "shape = \"capsule\", radius = 0.6, half_length = 1.5",
    "shape = \"disk\", radius = 1, half_length = 0.3",
    "shape = \"torus\", radius = 1, tube_radius = 0.4",
    "shape = \"helix\", radius = 0.6, tube_radius = 0.25, pitch = 1.2, turns = 1.4",
];

const SMALL: &str = "domain = { kind = \"ball\", radius = 8 }\nfem.size_factor = 1.75";

#[test]
#[ignore = "slow: 30 s"]
fn resistances_of_all_shapes_are_symmetric_and_positive_definite() {
    for shape in SHAPES {
        let scene = loaded(
            shape,
            Vector3::new(10.0, 30.0, -50.0),
            [Vector3::x(); 2],
            SMALL,
        );
        let mut model = FemModel::new(&scene).expect("a model");
        let state = scene.initial_state();
        let configuration = Configuration {
            state: &state,
            shape: &[],
        };
        let resistance = model
            .resistance(configuration)
            .expect("a resistance")
            .matrix;
        let asymmetry = (&resistance - resistance.transpose()).amax() / resistance.amax();
        // Six solves to 1e-8, and the corrections of each.
        assert!(asymmetry < 1e-5, "{shape}: {asymmetry:.1e}");
        let smallest = resistance.symmetric_eigenvalues().min();
        assert!(smallest > 0.0, "{shape}: {smallest}");
    }
}

/// Velocities in the frame of the body, and their bar.
fn own_motion(shape: &str, orientation: Vector3<f64>) -> ([Vector3<f64>; 2], f64) {
    let turn = UnitQuaternion::from_scaled_axis(orientation);
    let loads = [Vector3::new(3.0, -2.0, 5.0), Vector3::new(-4.0, 1.0, 2.0)];
    // Unbounded fluid has no frame.
    let instant = solve(&loaded(
        shape,
        orientation,
        loads.map(|l| turn * l),
        "fem.size_factor = 1.75",
    ));
    let body = &instant.bodies[0];
    let motion = [body.velocity, body.angular_velocity].map(|v| turn.inverse() * v);
    (motion, instant.error_estimate.total())
}

fn assert_indifferent(shape: &str, orientation: Vector3<f64>) {
    let ([u, w], bar) = own_motion(shape, Vector3::zeros());
    let ([turned_u, turned_w], turned_bar) = own_motion(shape, orientation);
    let change = (turned_u - u).norm();
    assert!(
        change <= bar + turned_bar,
        "{shape} {orientation}: {change:.1e} {bar:.1e}"
    );
    // The bar is that of velocities; angular velocities have about the same relative accuracy.
    let spin = (turned_w - w).norm() / w.norm();
    assert!(spin < 4e-3, "{shape} {orientation}: {spin:.1e}");
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
    let scene = loaded(SHAPES[0], Vector3::zeros(), loads, SMALL);
    let mut state = scene.initial_state();
    let mut model = FemModel::new(&scene).expect("a model");
    let mut at = |model: &mut FemModel, angle: f64| {
        let turn = UnitQuaternion::from_scaled_axis(angle * Vector3::new(0.6, 0.0, 0.8));
        state.attitudes[0] = turn;
        let poses = scene.articulation().place(&state, &[]).expect("poses");
        assert!(poses[0].rotation.angle_to(&turn) < 1e-12);
        let configuration = Configuration {
            state: &state,
            shape: &[],
        };
        model.solve_one(configuration, &[]).expect("a solution")
    };
    at(&mut model, 0.0);
    let moved = at(&mut model, 0.2);
    assert!(moved.remeshed.is_none(), "{:?}", moved.remeshed);
    let new = at(&mut FemModel::new(&scene).expect("a model"), 0.2);
    let [a, b] = [&moved, &new].map(|s| s.bodies[0].velocity);
    let bars = moved.error_estimate.total() + new.error_estimate.total();
    assert!((a - b).norm() <= bars, "{a} {b} {bars:.1e}");
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
        let options = format!("fem.size_factor = {size:?}");
        let instant = solve(&loaded(&shape, Vector3::zeros(), loads, &options));
        (instant.bodies[0].velocity.x, instant.error_estimate.total())
    };
    let (right, bar) = motion(1.5, 1.75);
    let (left, _) = motion(-1.5, 1.75);
    let (finer, finer_bar) = motion(1.5, 1.0);
    // A corkscrew: torque and spin along +x push a right-handed helix along +x.
    assert!(right > 10.0 * bar, "{right} {bar}");
    assert!((right + left).abs() <= 2.0 * bar, "{right} {left} {bar}");
    assert!(
        (right - finer).abs() <= bar + finer_bar,
        "{right} {finer} {bar} {finer_bar}"
    );
}

/// The scene of three capsules end to end runs with its forces in balance.
#[test]
#[ignore = "slow: 40 s"]
fn the_capsule_swimmer_swims() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/capsule-swimmer.toml");
    let scene = Scene::read(&path, &[]).expect("the scene of the gallery");
    let mut model = choose(&scene).expect("a model").model;
    assert_eq!(model.name(), "fem");
    let start = solve_start(&scene, model.as_mut()).expect("a solution");
    let force: Vector3<f64> = start.bodies.iter().map(|b| b.force).sum();
    let largest = start
        .bodies
        .iter()
        .map(|b| b.force.norm())
        .fold(0.0, f64::max);
    assert!(force.norm() < 1e-6 * largest, "{force} {largest}");
    let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ()).expect("a run");
    // The bar is 0.000070; without an exact value this keeps the answer where it was computed.
    assert!((outcome.net() - 0.092721).abs() < 3e-4, "{}", outcome.net());
}

/// The scene of the gallery with this name, run.
fn run_of_gallery(name: &str) -> Outcome {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let scene = Scene::read(&folder.join(name), &[]).expect("a scene of the gallery");
    let mut model = choose(&scene).expect("a model").model;
    simulate(&scene, model.as_mut(), Method::Collocation, &mut ()).expect("a run")
}

/// The bar is 0.00024; without an exact value these numbers keep the answer where it was computed.
#[test]
#[ignore = "slow: 16 s"]
fn the_swimmer_in_a_bent_channel_swims_and_turns() {
    let outcome = run_of_gallery("bent-channel.toml");
    assert!((outcome.net() - 0.04202).abs() < 5e-4, "{}", outcome.net());
    let turn = outcome.rotation;
    assert!(
        (turn.z + 9.6e-4).abs() < 2e-4 && turn.xy().norm() < 2e-4,
        "{turn}"
    );
}

/// It falls between the spheres and makes about half a turn.
#[test]
#[ignore = "slow: 10 s"]
fn the_ellipsoid_between_two_fixed_spheres_tumbles() {
    let outcome = run_of_gallery("tumbling-ellipsoid.toml");
    assert!((outcome.net() - 1.1293).abs() < 8e-3, "{}", outcome.net());
    let turn = outcome.rotation;
    assert!(
        (turn.z - 2.982).abs() < 2e-2 && turn.xy().norm() < 1e-2,
        "{turn}"
    );
}
