//! Tables over shape space, compared with the tabulated model.

use nalgebra::{DMatrix, Isometry3, Translation3, UnitQuaternion, Vector3};
use rigid::State;
use swimmer::models::ShapeSpace;
use swimmer::models::{Configuration, Hydrodynamics, ModelError};
use swimmer::{Choice, choose, with_tables};
use swimmer::{Method, Outcome, Scene, simulate};

fn template(text: &str, overrides: &[&str]) -> Scene {
    let mut document = scene::Document::parse(text, std::path::Path::new("scene.toml")).unwrap();
    for assignment in overrides {
        document.set(assignment).unwrap();
    }
    Scene::from_document(document).unwrap()
}

const COLLINEAR: &str = include_str!("../../templates/three-sphere.toml");
const PLANAR: &str = include_str!("../../templates/planar.toml");

fn model(scene: &Scene) -> Box<dyn Hydrodynamics> {
    choose(scene).unwrap().model
}

/// The outcomes without and with tables.
fn both_ways(scene: &Scene) -> (Outcome, Outcome) {
    let direct = simulate(scene, model(scene).as_mut(), Method::Collocation, &mut ()).unwrap();
    let Choice { mut model, reasons } = with_tables(scene, choose(scene).unwrap()).unwrap();
    assert!(
        reasons.iter().any(|r| r.contains("tabulated")),
        "{reasons:?}"
    );
    let table = simulate(scene, model.as_mut(), Method::Collocation, &mut ()).unwrap();
    (direct, table)
}

fn assert_within_error_bars(scene: &Scene) {
    let (direct, table) = both_ways(scene);
    let error_bars = direct.error_estimate.total() + table.error_estimate.total();
    for (a, b) in direct.displacement.iter().zip(&table.displacement) {
        assert!((a - b).norm() <= error_bars, "{a} {b} {error_bars:e}");
    }
    // A rotation moves the bodies by up to the length of the arms.
    let longest_arm = scene
        .articulation()
        .initial_shape()
        .iter()
        .fold(0.0_f64, |m, l| m.max(*l));
    assert!((direct.rotation - table.rotation).norm() * longest_arm <= 2.0 * error_bars);
    // Forces are as accurate as velocities.
    let path: f64 = direct
        .spans
        .iter()
        .flat_map(|span| span.displacement.iter().map(|d| d.norm()))
        .sum();
    assert!((direct.work - table.work).abs() <= 10.0 * error_bars / path * direct.work.abs());
    // Strokes with a small net displacement may miss the tolerance in both cases.
    assert!(table.tolerance_met || !direct.tolerance_met);
    // The error bars are small enough to be useful.
    assert!(error_bars < scene.model().tolerance * path);
}

#[test]
fn strokes_with_tables_are_those_of_the_model() {
    for tolerance in ["1e-3", "1e-6"] {
        let tolerance = format!("model.tolerance={tolerance}");
        let overrides = ["model.kind=\"multipole\"", "gait.cycles=3", &tolerance];
        assert_within_error_bars(&template(COLLINEAR, &overrides));
    }
}

#[test]
fn rotating_swimmers_are_followed_through_all_cycles() {
    for arms in ["clamped", "free", "lab"] {
        let arms = format!("gait.arms=\"{arms}\"");
        let overrides = ["model.kind=\"multipole\"", "gait.cycles=3", &arms];
        assert_within_error_bars(&template(PLANAR, &overrides));
    }
}

#[test]
fn connection_and_metric_are_those_of_the_model_anywhere_in_the_box() {
    let scene = template(
        COLLINEAR,
        &["model.kind=\"multipole\"", "model.tolerance=1e-5"],
    );
    let mut model = model(&scene);
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
            let configuration = Configuration {
                state: &state,
                shape: &shape,
            };
            let exact = model.solve_one(configuration, &rates).unwrap();
            let found = space.connection(&shape).unwrap()[joint];
            assert!((found.linear - exact.motion.frames[0].linear).norm() <= bar);
            assert!(found.angular.norm() < 1e-9);
            for (body, b) in exact.bodies.iter().enumerate() {
                powers[(joint, joint)] += b.force.dot(&b.velocity);
                let other = space.solution(configuration, &rates).unwrap().bodies[body];
                assert!((other.velocity - b.velocity).norm() <= bar);
                assert!((other.force - b.force).norm() <= 100.0 * bar);
            }
        }
        let metric = space.metric(&shape).unwrap();
        for joint in 0..2 {
            assert!((metric[(joint, joint)] / powers[(joint, joint)] - 1.0).abs() < 10.0 * bar);
        }
        // Lorentz reciprocity.
        assert!((metric[(0, 1)] - metric[(1, 0)]).abs() < 100.0 * bar);
        assert!(metric.cholesky().is_some());
        // The motion of a rotated swimmer is the rotated motion.
        let rates = [0.7, -0.2];
        let configuration = Configuration {
            state: &state,
            shape: &shape,
        };
        let here = space.solution(configuration, &rates).unwrap();
        state = State {
            frames: state
                .frames
                .iter()
                .map(|f| {
                    Isometry3::from_parts(Translation3::new(3.0, 1.0, -2.0), turn * f.rotation)
                })
                .collect(),
            ..state
        };
        let configuration = Configuration {
            state: &state,
            shape: &shape,
        };
        let exact = model.solve_one(configuration, &rates).unwrap();
        let there = space.solution(configuration, &rates).unwrap();
        for ((a, b), c) in here.bodies.iter().zip(&there.bodies).zip(&exact.bodies) {
            assert!((turn * a.velocity - b.velocity).norm() < 1e-13);
            assert!((c.velocity - b.velocity).norm() <= bar);
        }
    }
}

#[test]
fn tables_are_refused_if_the_motion_depends_on_more_than_the_shape() {
    let refused = |scene: &Scene, ranges: &[(f64, f64)]| {
        let mut model = model(scene);
        let error = ShapeSpace::tabulate(scene, model.as_mut(), ranges, 1e-3).unwrap_err();
        assert!(matches!(error, ModelError::ShapeSpace { .. }), "{error}");
        error.to_string()
    };
    let multipole = "model.kind=\"multipole\"";
    let box_of = [(6.0, 10.0), (6.0, 10.0)];
    let pulled = template(COLLINEAR, &[multipole, "bodies.left.force=[0, 0, 1]"]);
    assert!(refused(&pulled, &box_of).contains("external loads"));
    let free = template(COLLINEAR, &[multipole]);
    assert!(refused(&free, &box_of[..1]).contains("every link"));
    assert!(refused(&free, &[(10.0, 6.0), (6.0, 10.0)]).contains("every link"));
    assert!(refused(&free, &[(10.0, 10.0), (6.0, 6.0)]).contains("no length varies"));
    // Spheres that touch within the box are refused by the model.
    let mut model = model(&free);
    let touching = ShapeSpace::tabulate(&free, model.as_mut(), &[(1.0, 10.0), (6.0, 10.0)], 1e-3);
    assert!(touching.is_err());
}
