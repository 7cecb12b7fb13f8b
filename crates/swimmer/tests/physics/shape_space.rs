//! Tables over shape space, compared with the tabulated model.

use nalgebra::{DMatrix, Isometry3, Translation3, UnitQuaternion, Vector3};
use rigid::State;
use swimmer::models::{ModelError, ShapeSpace};
use swimmer::{Choice, Method, Outcome, Scene, choose, with_tables};
use testkit::{SceneText, at, boxed, run, run_by, within};

fn collinear() -> SceneText {
    let text = include_str!("../../templates/three-sphere.toml");
    SceneText::file(text).with("model.kind", "multipole")
}

fn planar() -> SceneText {
    SceneText::file(include_str!("../../templates/planar.toml")).with("model.kind", "multipole")
}

/// The outcomes without and with tables.
fn both_ways(scene: &Scene) -> (Outcome, Outcome) {
    let Choice {
        mut model, reasons, ..
    } = with_tables(scene, choose(scene).unwrap()).unwrap();
    assert!(
        reasons.iter().any(|r| r.contains("tabulated")),
        "{reasons:?}"
    );
    (run(scene), run_by(model.as_mut(), Method::Collocation))
}

fn assert_within_error_bars(scene: &Scene) {
    let (direct, table) = both_ways(scene);
    let error_bars = direct.error_estimate.total() + table.error_estimate.total();
    for (a, b) in direct.displacement.iter().zip(&table.displacement) {
        within((a - b).norm(), error_bars, "both error bars");
    }
    // A rotation moves the bodies by up to the length of the arms.
    let arms = scene.articulation().initial_shape();
    let longest_arm = arms.iter().fold(0.0_f64, |m, l| m.max(*l));
    let turned = (direct.rotation - table.rotation).norm() * longest_arm;
    within(turned, 2.0 * error_bars, "both error bars, at both ends");
    let spans = direct.spans.iter().flat_map(|span| &span.displacement);
    let path: f64 = spans.map(|d| d.norm()).sum();
    let bound = 10.0 * error_bars / path * direct.work.abs();
    within(
        direct.work - table.work,
        bound,
        "forces are as accurate as velocities",
    );
    // Strokes with a small net displacement may miss the tolerance in both cases.
    assert!(table.tolerance_met || !direct.tolerance_met);
    // The error bars are small enough to be useful.
    assert!(error_bars < scene.model().tolerance * path);
}

#[test]
fn strokes_with_tables_are_those_of_the_model() {
    for tolerance in ["1e-3", "1e-6"] {
        let text = collinear().with("model.tolerance", tolerance);
        assert_within_error_bars(&text.with("gait.cycles", 3).scene());
    }
}

#[test]
fn rotating_swimmers_are_followed_through_all_cycles() {
    for arms in ["clamped", "free", "lab"] {
        let text = planar().with("gait.arms", arms);
        assert_within_error_bars(&text.with("gait.cycles", 3).scene());
    }
}

#[test]
fn connection_and_metric_are_those_of_the_model_anywhere_in_the_box() {
    let scene = collinear().tolerance(1e-5).scene();
    let mut model = boxed(&scene);
    let ranges = [(5.0, 10.0), (6.0, 12.0)];
    let space = ShapeSpace::tabulate(&scene, model.as_mut(), &ranges, 1e-7).unwrap();
    let bar = space.errors().0 + 2.0 * space.errors().1;
    assert!(bar < 1e-5, "{bar:e}");
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.4, 1.1));
    for (a, b) in [(5.0, 6.0), (7.77, 6.1), (9.9, 11.3), (10.0, 12.0)] {
        let shape = [a, b];
        let mut state = scene.initial_state();
        let mut powers = DMatrix::<f64>::zeros(2, 2);
        for joint in 0..2 {
            let mut rates = [0.0; 2];
            rates[joint] = 1.0;
            let configuration = at(&state, &shape);
            let exact = model.solve_one(configuration, &rates).unwrap();
            let found = space.connection(&shape).unwrap()[joint];
            let error = found.linear - exact.motion.frames[0].linear;
            within(error.norm(), bar, "the error bar of the table");
            within(found.angular.norm(), 1e-9, "rounding");
            for (body, b) in exact.bodies.iter().enumerate() {
                powers[(joint, joint)] += b.force.dot(&b.velocity);
                let other = space.solution(configuration, &rates).unwrap().bodies[body];
                within(
                    (other.velocity - b.velocity).norm(),
                    bar,
                    "the error bar of the table",
                );
                within(
                    (other.force - b.force).norm(),
                    100.0 * bar,
                    "resistances below 100",
                );
            }
        }
        let metric = space.metric(&shape).unwrap();
        for joint in 0..2 {
            let ratio = metric[(joint, joint)] / powers[(joint, joint)];
            within(
                ratio - 1.0,
                10.0 * bar,
                "the bar relative to a power above ten",
            );
        }
        within(
            metric[(0, 1)] - metric[(1, 0)],
            100.0 * bar,
            "Lorentz reciprocity",
        );
        assert!(metric.cholesky().is_some());
        // The motion of a rotated swimmer is the rotated motion.
        let rates = [0.7, -0.2];
        let configuration = at(&state, &shape);
        let here = space.solution(configuration, &rates).unwrap();
        state = State {
            frames: (state.frames.iter())
                .map(|f| {
                    Isometry3::from_parts(Translation3::new(3.0, 1.0, -2.0), turn * f.rotation)
                })
                .collect(),
            ..state
        };
        let configuration = at(&state, &shape);
        let exact = model.solve_one(configuration, &rates).unwrap();
        let there = space.solution(configuration, &rates).unwrap();
        for ((a, b), c) in here.bodies.iter().zip(&there.bodies).zip(&exact.bodies) {
            within((turn * a.velocity - b.velocity).norm(), 1e-13, "rounding");
            within(
                (c.velocity - b.velocity).norm(),
                bar,
                "the error bar of the table",
            );
        }
    }
}

#[test]
fn tables_are_refused_if_the_motion_depends_on_more_than_the_shape() {
    let refused = |scene: &Scene, ranges: &[(f64, f64)]| {
        let table = ShapeSpace::tabulate(scene, boxed(scene).as_mut(), ranges, 1e-3);
        let error = table.unwrap_err();
        assert!(matches!(error, ModelError::ShapeSpace { .. }), "{error}");
        error.to_string()
    };
    let box_of = [(6.0, 10.0), (6.0, 10.0)];
    let pulled = collinear().with("bodies.left.force", "[0, 0, 1]").scene();
    assert!(refused(&pulled, &box_of).contains("external loads"));
    let free = collinear().scene();
    assert!(refused(&free, &box_of[..1]).contains("every link"));
    assert!(refused(&free, &[(10.0, 6.0), (6.0, 10.0)]).contains("every link"));
    assert!(refused(&free, &[(10.0, 10.0), (6.0, 6.0)]).contains("no length varies"));
    // Spheres that touch within the box are refused by the model.
    let mut model = boxed(&free);
    let touching = ShapeSpace::tabulate(&free, model.as_mut(), &[(1.0, 10.0), (6.0, 10.0)], 1e-3);
    assert!(touching.is_err());
}
