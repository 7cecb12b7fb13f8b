//! Strokes of swimmers on the mesh-free double: exact numbers and exact properties.

mod euler_bars;
mod support;

use approx::assert_abs_diff_eq;
use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use support::{Run, STROKE, Tensor, run, run_with, scene, three_spheres};
use swimmer::models::{SphereModel, SpheresModel};
use swimmer::{Method, SwimError};

const FREE: &str = r#"{ kind = "unbounded" }"#;
const WALL: &str = r#"{ kind = "wall" }"#;

/// Steps of the centre sphere from the reference table of exact answers (three spheres of radius 1, arms 10 to 6).
const RPY: [f64; 4] = [
    -1.3529873030998665,
    1.435496826965346,
    1.435496826965347,
    -1.3529873030998667,
];
const OSEEN: [f64; 4] = [
    -1.353092738366866,
    1.4391384581513114,
    1.4391384581513114,
    -1.3530927383668663,
];

/// The three-sphere swimmer along x at a height over the wall z = 0.
fn over_wall(height: f64, tolerance: f64) -> String {
    three_spheres(&format!("model.tolerance = {tolerance}"), WALL)
        .replace(", 0, 0]", &format!(", 0, {height}]"))
}

fn follow(text: &str) -> Run {
    run(&scene(text), Tensor::Rpy, Method::Collocation).unwrap()
}

#[test]
fn the_three_sphere_stroke_has_the_steps_of_the_reference() {
    for (tensor, steps) in [(Tensor::Rpy, RPY), (Tensor::Oseen, OSEEN)] {
        let text = three_spheres("model.tolerance = 1e-9", FREE);
        let run = run(&scene(&text), tensor, Method::Collocation).unwrap();
        for (leg, step) in run.moves.iter().zip(steps) {
            assert_abs_diff_eq!(leg[1].x, step, epsilon = 1e-10);
            assert!(leg[1].yz().norm() < 1e-12);
        }
    }
}

#[test]
fn a_tolerance_is_met_and_the_error_bar_contains_the_error() {
    for text in [
        |tolerance: f64| three_spheres(&format!("model.tolerance = {tolerance}"), FREE),
        |tolerance: f64| over_wall(20.0, tolerance),
        |tolerance: f64| over_wall(5.0, tolerance),
    ] {
        let exact = follow(&text(1e-11)).net(1);
        for tolerance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
            let run = follow(&text(tolerance));
            let error = (run.net(1) - exact).norm();
            // The bar of a leg is for its largest displacement of any body, so the sum of legs bounds the net.
            assert!(
                error <= run.integration_error(),
                "{error:e} > {:e}",
                run.integration_error()
            );
            assert!(
                error <= tolerance * exact.norm(),
                "{error:e} at {tolerance:e}"
            );
            assert!(run.legs.iter().all(|leg| leg.tolerance_met));
        }
    }
}

#[test]
fn a_stroke_to_1e_4_takes_at_most_24_solves() {
    assert!(follow(&three_spheres("model.tolerance = 1e-4", FREE)).solves() <= 24);
    assert!(follow(&over_wall(20.0, 1e-4)).solves() <= 24);
}

#[test]
fn euler_is_of_first_order_where_the_position_matters() {
    let exact = follow(&over_wall(5.0, 1e-10)).net(1);
    let error = |steps| {
        let scene = scene(&over_wall(5.0, 1e-3));
        (run(&scene, Tensor::Rpy, Method::Euler { steps })
            .unwrap()
            .net(1)
            - exact)
            .norm()
    };
    // Halving the step halves the error, up to the next order: 1/40 relative at 20 steps a leg.
    assert_abs_diff_eq!(error(20) / error(40), 2.0, epsilon = 0.1);
    assert!(error(40) > 100.0 * (follow(&over_wall(5.0, 1e-3)).net(1) - exact).norm());
}

#[test]
fn the_reversed_stroke_goes_back_the_same_way() {
    // All eight phases: the stroke and its reverse. Near a wall, the position matters on the way.
    let back = r#"
        [[gait.phases]]
        link = "right-arm"
        length = 6
        [[gait.phases]]
        link = "left-arm"
        length = 6
        [[gait.phases]]
        link = "right-arm"
        length = 10
        [[gait.phases]]
        link = "left-arm"
        length = 10
    "#;
    for text in [
        three_spheres("model.tolerance = 1e-11", FREE),
        over_wall(5.0, 1e-11),
    ] {
        let run = follow(&format!("{text}{back}"));
        for body in 0..3 {
            assert!(run.net(body).norm() < 1e-10, "{:e}", run.net(body).norm());
        }
        assert!(run.moves[..4].iter().map(|m| m[1].x).sum::<f64>() > 0.15);
    }
}

#[test]
fn a_reciprocal_stroke_goes_nowhere() {
    // Purcell's scallop theorem, with one hinge open and close.
    let scallop = &STROKE[..STROKE
        .find("[[gait.phases]]\n        link = \"right-arm\"")
        .unwrap()];
    let opening = scallop.replace('6', "10");
    for text in [
        three_spheres("model.tolerance = 1e-11", FREE),
        over_wall(4.0, 1e-11),
    ] {
        let run = follow(&text.replace(STROKE, &format!("{scallop}{opening}")));
        assert_eq!(run.moves.len(), 2);
        assert!(run.net(1).norm() < 1e-10, "{:e}", run.net(1).norm());
    }
}

#[test]
fn neither_rate_nor_viscosity_matters() {
    let base = over_wall(5.0, 1e-6);
    let usual = follow(&base);
    // Other durations of every phase, and a fluid a billion times as thick.
    let mut changed = base.replace("length = 6\n", "length = 6\nduration = 1e-3\n");
    changed = changed.replace("length = 10\n", "length = 10\nduration = 37\n");
    changed = format!("fluid.viscosity = 1e9\n{changed}");
    let slow = follow(&changed);
    for body in 0..3 {
        assert!((usual.net(body) - slow.net(body)).norm() < 1e-11);
    }
    // Work is viscosity times a rate, phase by phase: opening is 37 times slower, closing 1000 times faster.
    for (leg, factor) in [(0, 1e3), (3, 1.0 / 37.0)] {
        let (a, b) = (usual.legs[leg].work, slow.legs[leg].work);
        assert!((b / (1e9 * factor * a) - 1.0).abs() < 1e-11);
    }
}

#[test]
fn the_mirrored_stroke_swims_the_other_way() {
    let text = three_spheres("model.tolerance = 1e-9", FREE);
    let swapped = text.replace(
        STROKE,
        &STROKE
            .replace("left", "L")
            .replace("right", "left")
            .replace('L', "right"),
    );
    let (run, mirrored) = (follow(&text), follow(&swapped));
    assert_abs_diff_eq!(run.net(1).x, -mirrored.net(1).x, epsilon = 1e-12);
    for (a, b) in run.moves.iter().zip(&mirrored.moves) {
        assert_abs_diff_eq!(a[0].x, -b[2].x, epsilon = 1e-12);
    }
}

#[test]
fn cycles_of_a_free_swimmer_repeat() {
    let once = follow(&three_spheres("model.tolerance = 1e-6", FREE));
    let thrice = follow(&three_spheres(
        "model.tolerance = 1e-6\ngait.cycles = 3",
        FREE,
    ));
    assert_eq!(thrice.moves.len(), 12);
    assert_abs_diff_eq!(thrice.net(1).x, 3.0 * once.net(1).x, epsilon = 1e-12);
}

#[test]
fn a_gap_that_the_wall_closes_is_a_collision_with_place_and_phase() {
    // A stone falls onto the wall; the step is so long that it is found below.
    let text = r#"
        domain.kind = "wall"
        gait.phases = [{ duration = 100 }]
        [[bodies]]
        name = "stone"
        radius = 1
        position = [0, 0, 3]
        force = [0, 0, -30]
    "#;
    match run(&scene(text), Tensor::Oseen, Method::Euler { steps: 2 }) {
        Err(error @ SwimError::Collision { .. }) => {
            assert!(
                error.to_string().contains("'stone' touches the wall"),
                "{error}"
            );
            assert_eq!(error.exit_code(), 3);
        }
        other => panic!("{:?}", other.map(|run| run.net(0))),
    }
}

/// A planar swimmer of three arms from a junction, turned as a whole.
fn planar(turn: &UnitQuaternion<f64>, shift: &Vector3<f64>, arms: &str) -> String {
    let mut text = format!("gait.arms = \"{arms}\"\nmodel.tolerance = 1e-9\n");
    let place = |x: Vector3<f64>| {
        let x = turn * x + shift;
        format!("[{:?}, {:?}, {:?}]", x.x, x.y, x.z)
    };
    text += &format!(
        "[[bodies]]\nname = \"joint\"\nshape = \"point\"\nposition = {}\n",
        place(Vector3::zeros())
    );
    for k in 0..3 {
        let angle = f64::from(k) * std::f64::consts::TAU / 3.0;
        let x = place(6.0 * Vector3::new(angle.cos(), angle.sin(), 0.0));
        text += &format!("[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = {x}\n");
        text += &format!("[[links]]\nname = \"a{k}\"\nbody = \"s{k}\"\nto = \"joint\"\n");
    }
    for (arm, length) in [(0, 4), (1, 4), (0, 6), (1, 6)] {
        text += &format!("[[gait.phases]]\nlink = \"a{arm}\"\nlength = {length}\n");
    }
    text
}

#[test]
fn the_planar_swimmer_moves_and_turns_in_its_plane() {
    let still = (UnitQuaternion::identity(), Vector3::zeros());
    for (arms, turns) in [("clamped", true), ("free", true), ("lab", false)] {
        let run = follow(&planar(&still.0, &still.1, arms));
        let end = &run.legs.last().unwrap().end.frames[0];
        let rotation = end.rotation.scaled_axis();
        assert!(rotation.xy().norm() < 1e-12 && run.net(0).z.abs() < 1e-12);
        // The reference gives 0.0271 (clamped), 0.0282 (free), 0 (lab) with full hydrodynamics.
        assert_eq!(rotation.z > 0.01, turns, "{arms}: {rotation}");
    }
}

#[test]
fn a_tolerance_that_is_missed_is_told() {
    // The planar swimmer gains so little that a leg's usual share is not enough.
    let still = (UnitQuaternion::identity(), Vector3::zeros());
    let outcome = |text: &str| {
        let scene = scene(text);
        let mut double = support::Double::new(&scene, Tensor::Rpy);
        swimmer::simulate(&scene, &mut double, Method::Collocation, &mut ()).unwrap()
    };
    let at = |tolerance: f64| {
        let text = planar(&still.0, &still.1, "clamped");
        outcome(&text.replace("tolerance = 1e-9", &format!("tolerance = {tolerance}")))
    };
    let (loose, tight) = (at(0.03), at(1e-7));
    let error = (loose.displacement[0] - tight.displacement[0]).norm();
    assert!(error <= loose.error_estimate.integration.unwrap());
    assert!(
        !loose.tolerance_met,
        "{:?} of {}",
        loose.error_estimate,
        loose.net()
    );
    let swimmer = outcome(&three_spheres("model.tolerance = 1e-3", FREE));
    let exact: f64 = RPY.iter().sum();
    assert!(swimmer.tolerance_met && (swimmer.net() - exact).abs() < 1e-3 * exact);
    // Rungs of one, two and three points a leg, of which the last stays; and the ends of legs.
    assert_eq!((swimmer.legs.len(), swimmer.solves), (4, 24));
    assert_eq!(swimmer.samples.len(), 1 + 4 * (3 + 1));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn turning_the_scene_turns_the_motion(axis in prop::array::uniform3(-3.0_f64..3.0), shift in prop::array::uniform3(-9.0_f64..9.0)) {
        let turn = UnitQuaternion::from_scaled_axis(Vector3::from(axis));
        let usual = follow(&planar(&UnitQuaternion::identity(), &Vector3::zeros(), "clamped"));
        let turned = follow(&planar(&turn, &Vector3::from(shift), "clamped"));
        for body in 0..4 {
            prop_assert!((turn * usual.net(body) - turned.net(body)).norm() < 1e-10);
        }
        let rotation = |run: &Run| run.legs.last().unwrap().end.frames[0].rotation.scaled_axis();
        prop_assert!((turn * rotation(&usual) - rotation(&turned)).norm() < 1e-10);
    }

    #[test]
    fn order_of_the_bodies_does_not_matter(tolerance in 1e-7_f64..1e-3) {
        let text = three_spheres(&format!("model.tolerance = {tolerance}"), FREE);
        let usual = follow(&text);
        let tail = text.split("[[bodies]]").last().unwrap();
        let (bodies, links) = tail.split_once("[[links]]").unwrap();
        let head = text.split("[[bodies]]").collect::<Vec<_>>();
        let moved = format!("{}[[bodies]]{}[[bodies]]{}[[bodies]]{}[[links]]{}", head[0], bodies, head[1], head[2], links);
        let other = follow(&moved);
        // Another root has other displacements, so the ladder may stop elsewhere: equal within the bars.
        let bars = usual.integration_error() + other.integration_error();
        prop_assert!((usual.net(1) - other.net(2)).norm() <= bars);
    }
}

#[test]
fn the_runge_kutta_pair_meets_its_tolerance_and_its_bar_holds() {
    for text in [
        |tolerance: f64| three_spheres(&format!("model.tolerance = {tolerance}"), FREE),
        |tolerance: f64| over_wall(5.0, tolerance),
    ] {
        let exact = follow(&text(1e-11)).net(1);
        let mut solves = 0;
        for tolerance in [1e-2, 1e-4, 1e-6, 1e-8] {
            let run = run(&scene(&text(tolerance)), Tensor::Rpy, Method::RungeKutta).unwrap();
            let error = (run.net(1) - exact).norm();
            // The embedded formula estimates the worse of the two, so its bar holds for the better.
            assert!(
                error <= run.integration_error(),
                "{error:e} at {tolerance:e}"
            );
            assert!(
                error <= tolerance * exact.norm(),
                "{error:e} at {tolerance:e}"
            );
            assert!(run.legs.iter().all(|leg| leg.tolerance_met));
            assert!(run.solves() >= solves);
            solves = run.solves();
        }
        // Order five: a tolerance a million times smaller takes 16 times the steps.
        assert!(solves < 1000, "{solves}");
    }
}

/// A scene by the model of spheres, which knows resistances.
fn of_spheres(text: &str, method: Method) -> Result<Run, SwimError> {
    let scene = scene(text);
    run_with(
        &scene,
        &mut SpheresModel::new(&scene, SphereModel::Rpy)?,
        method,
    )
}

/// A bent chain whose bodies have this mass and moment of inertia.
fn massive(mass: f64) -> String {
    let mut text = three_spheres("model.tolerance = 1e-9", FREE).replace("[10, 0, 0]", "[7, 6, 1]");
    text = text.replace(
        "radius = 1\n",
        &format!("radius = 1\nmass = {mass:e}\ninertia = {mass:e}\n"),
    );
    assert_eq!(text.matches("inertia").count(), 3);
    text
}

#[test]
fn light_bodies_move_as_those_without_inertia_and_heavy_ones_keep_their_momentum() {
    let follow = |text: &str, method| of_spheres(text, method).unwrap();
    let exact = follow(&massive(1e-9), Method::Collocation);
    let error = |steps| {
        let run = follow(&massive(1e-9), Method::BackwardEuler { steps });
        (run.net(1) - exact.net(1)).norm()
    };
    // First order.
    assert_abs_diff_eq!(error(20) / error(40), 2.0, epsilon = 0.1);
    // Equal masses that start at rest: R t / m is 1e-7, so their centre stays, up to the first order in which steps turn the arms.
    let heavy = follow(&massive(1e9), Method::BackwardEuler { steps: 20 });
    let centre = |run: &Run| ((0..3).map(|body| run.net(body)).sum::<Vector3<f64>>() / 3.0).norm();
    let coarser = follow(&massive(1e9), Method::BackwardEuler { steps: 10 });
    assert!(centre(&heavy) < 0.02 && centre(&heavy) < 0.6 * centre(&coarser) + 1e-6);
    assert!(heavy.moves[0].iter().any(|step| step.norm() > 1.0));
}

#[test]
fn explicit_steps_with_inertia_are_refused_beyond_their_limit() {
    // One sphere, J = 1: the fastest relaxation is that of its rotation, 1/(8 pi); two of it are the limit.
    let limit = 2.0 / (8.0 * std::f64::consts::PI);
    let pulled = |step: f64| {
        format!(
            "gait.phases = [{{ duration = {:?} }}]\n[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\nforce = [1, 0, 0]\nmass = 1\ninertia = 1\n",
            50.0 * step
        )
    };
    let method = Method::ExplicitInertia { steps: 50 };
    let step = 0.99 * limit;
    let stable = of_spheres(&pulled(step), method).unwrap();
    // v_k = F/R (1 - g^k) with g = 1 - R dt / m, and a step moves by dt v_k.
    let drag = 6.0 * std::f64::consts::PI;
    let g = 1.0 - drag * step;
    let sum = g * (1.0 - g.powi(50)) / (1.0 - g);
    assert_abs_diff_eq!(stable.net(0).x, step * (50.0 - sum) / drag, epsilon = 1e-12);
    match of_spheres(&pulled(1.01 * limit), method) {
        Err(error @ SwimError::Unstable { .. }) => {
            assert_eq!(error.exit_code(), 3);
            assert!(
                error.to_string().contains("take 51 steps a phase"),
                "{error}"
            );
        }
        other => panic!("{:?}", other.map(|run| run.net(0))),
    }
    // Without mass there is nothing to step.
    let massless = pulled(limit).replace("mass = 1\n", "");
    assert!(matches!(
        of_spheres(&massless, Method::BackwardEuler { steps: 5 }),
        Err(SwimError::Scene(swimmer::SceneError::BadValue { .. }))
    ));
}
