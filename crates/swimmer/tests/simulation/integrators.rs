//! Accuracy and cost of the integration methods.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use rigid::{JointLoad, Twist};
use swimmer::models::{
    BodySolution, DiscretisationError, Hydrodynamics, InstantaneousSolution, SphereModel,
    SpheresModel, Uncertainty,
};
use swimmer::{Integrator, Method, Scene, spans};
use testkit::{Recording, SceneText, three_spheres, within};

use crate::strokes::over_wall;
use crate::support::{Run, Tensor, follow, run, run_with};

/// Free, far from a wall and near it, in the order of the difficulty.
const PLACES: [fn(f64) -> SceneText; 3] = [
    |tolerance| three_spheres().tolerance(tolerance),
    |tolerance| over_wall(20.0, tolerance),
    |tolerance| over_wall(5.0, tolerance),
];

/// Asserts that the error of the net displacement is within its bar, and both within the tolerance.
///
/// The error bar of a phase span refers to the largest displacement of any body, so the sum over
/// the phase spans bounds the error of the net displacement. That of a Runge-Kutta pair is the
/// error of the less accurate formula and bounds that of the other.
fn assert_tolerance(run: &Run, exact: Vector3<f64>, tolerance: f64) {
    let (error, bar) = ((run.net(1) - exact).norm(), run.integration_error());
    within(error, bar, format!("the error bar at {tolerance:e}"));
    within(error, tolerance * exact.norm(), "the tolerance");
    within(
        bar,
        tolerance * exact.norm(),
        "the tolerance limits the bar",
    );
}

#[test]
fn collocation_meets_its_tolerance_and_the_error_bar_holds() {
    for text in PLACES {
        let exact = follow(&text(1e-11)).net(1);
        for tolerance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
            assert_tolerance(&follow(&text(tolerance)), exact, tolerance);
        }
    }
}

#[test]
fn a_stroke_takes_24_solves_to_1e_3_and_40_to_1e_4() {
    // Orders of one to three and of one to four points on each of four phase spans.
    for (tolerance, solves) in [(1e-3, 24), (1e-4, 40)] {
        for text in &PLACES[..2] {
            assert!(follow(&text(tolerance)).solves() <= solves);
        }
    }
}

#[test]
fn euler_is_of_first_order_where_the_position_matters() {
    let exact = follow(&over_wall(5.0, 1e-10)).net(1);
    let scene = over_wall(5.0, 1e-3).scene();
    let error = |method| (run(&scene, Tensor::Rpy, method).unwrap().net(1) - exact).norm();
    let [coarse, fine] = [20, 40].map(|steps| error(Method::Euler { steps }));
    within(
        coarse / fine - 2.0,
        0.1,
        "first order, up to 1/40 at 20 steps per phase span",
    );
    assert!(fine > 100.0 * error(Method::Collocation));
}

#[test]
fn the_runge_kutta_pair_meets_its_tolerance_and_its_error_bar_holds() {
    for text in [PLACES[0], PLACES[2]] {
        let exact = follow(&text(1e-11));
        let work = |run: &Run| run.spans.iter().map(|span| span.work).sum::<f64>();
        let (exact, exact_work) = (exact.net(1), work(&exact));
        let mut solves = 0;
        for tolerance in [1e-2, 1e-4, 1e-6, 1e-8] {
            let run = run(&text(tolerance).scene(), Tensor::Rpy, Method::RungeKutta).unwrap();
            assert_tolerance(&run, exact, tolerance);
            let bars = run
                .spans
                .iter()
                .map(|span| span.work_error.integration.unwrap());
            let bar = bars.sum::<f64>();
            within(
                work(&run) - exact_work,
                bar,
                format!("bar of the work at {tolerance:e}"),
            );
            within(bar, 10.0 * tolerance * exact_work, "the bar says something");
            assert!(run.solves() >= solves);
            solves = run.solves();
        }
        // Order five: a tolerance smaller by a factor of a million needs 16 times as many steps.
        assert!(solves < 1000, "{solves}");
    }
}

/// A model whose discretisation errors rotate with the swimmer.
fn with_discretisation_error(model: SpheresModel) -> Recording<'static> {
    Recording::changing(model, |query, solutions| {
        let rotation = query.configuration.state.frames[0].rotation;
        let vector = |k: usize| rotation * Vector3::new(1.0, 2.0, k as f64);
        for solution in solutions {
            // Before the correction everything is larger by these vectors.
            let mut response = &solution.response * 0.0;
            let (linear, angular) = (vector(3), vector(4));
            response.motion.frames = vec![Twist { linear, angular }];
            for (k, spin) in response.motion.spins.iter_mut().enumerate() {
                *spin = vector(5 + k);
            }
            for (k, body) in response.bodies.iter_mut().enumerate() {
                *body = BodySolution {
                    velocity: vector(10 + k),
                    angular_velocity: vector(15 + k),
                    force: vector(20 + k),
                    torque: vector(25 + k),
                };
            }
            let load = |joint: usize| JointLoad::new(vector(30 + joint), vector(40 + joint), 50.0);
            response.joint_loads = (0..2).map(load).collect();
            let uncertainty = Uncertainty::default();
            let mut error = DiscretisationError {
                response,
                uncertainty,
            };
            let exact = solution.clone();
            solution.correct(error.clone());
            let shifted = DiscretisationError::between(&exact, solution, uncertainty);
            let difference = shifted.bodies[1].torque - error.bodies[1].torque;
            within(difference.norm(), 1e-12, "rounding of numbers of about 30");
            *solution = exact;
            error.uncertainty.relative = 0.5;
            solution.mesh_error = Some(error);
        }
    })
}

/// All vectors of a solution.
fn vectors(solution: &InstantaneousSolution) -> Vec<Vector3<f64>> {
    let error = solution.mesh_error.as_ref().unwrap();
    let bodies = solution.bodies.iter();
    let motions = [&solution.motion, &error.motion];
    let frames = motions.into_iter().flat_map(|motion| &motion.frames);
    let spins = motions.into_iter().flat_map(|motion| &motion.spins);
    let loads = solution.joint_loads.iter().chain(&error.joint_loads);
    bodies
        .chain(&error.bodies)
        .flat_map(|b| [b.velocity, b.angular_velocity, b.force, b.torque])
        .chain(loads.flat_map(|load| [load.force, load.torque, load.drive * Vector3::x()]))
        .chain(spins.copied())
        .chain(frames.flat_map(|frame| [frame.linear, frame.angular]))
        .collect()
}

/// Solutions of a phase span are rotated to the corrected path, on which they belong to their
/// states.
#[test]
fn solutions_of_a_rotating_swimmer_are_the_solutions_at_their_states() {
    let scene = SceneText::file(include_str!("../../templates/planar.toml")).scene();
    let spheres = || SpheresModel::new(&scene, SphereModel::Rpy).unwrap();
    let model = || with_discretisation_error(spheres());
    let run = run_with(&scene, &mut model(), Method::Collocation).unwrap();
    let all = spans(scene.gait(), scene.articulation().initial_shape()).unwrap();
    let mut largest_angle = 0.0_f64;
    for (span, result) in all.zip(&run.spans) {
        for found in &result.solutions {
            let shape = span.shape(found.s);
            let configuration = testkit::at(&found.state, &shape);
            let exact = model()
                .solve_one(configuration, &span.rates(found.s))
                .unwrap();
            let (found, exact) = (vectors(&found.solution), vectors(&exact));
            assert_eq!(found.len(), exact.len());
            for (found, exact) in found.iter().zip(&exact) {
                // Velocities are of order one, forces and errors of order ten.
                let why = "rounding, amplified by the condition of the resistance, below 100";
                within((found - exact).norm(), 1e-12, why);
            }
        }
        largest_angle = largest_angle.max(result.end.frames[0].rotation.angle());
    }
    assert!(largest_angle > 0.01, "{largest_angle}");
}

/// A sphere that a rotating force drives around a circle of the radius `R`. A step over the angle
/// `θ` is interpolated with an error of `R θ⁴ / 384`, that of the cubic Hermite polynomial; the
/// chord is `R θ² / 8` away from the circle.
#[test]
fn bug_the_path_within_a_runge_kutta_step_was_a_straight_line() {
    let text = r#"
        model.kind = "rpy"
        bodies = [{ name = "a", radius = 1, position = [0, 0, 0], force = {
            amplitude = [1, 1, 0], phase = [1.5707963267948966, 0, 0], period = 1 } }]
        gait.phases = [{ duration = 1 }]
    "#;
    let scene = Scene::parse(text).unwrap();
    let mut model = swimmer::choose(&scene).unwrap().model;
    let span = spans(scene.gait(), &[]).unwrap().next().unwrap();
    let result = Integrator::new(&scene, model.as_mut(), Method::RungeKutta)
        .span(&span, &scene.initial_state(), &mut |_, _| Ok(()))
        .unwrap();
    // `V = F / (6 π μ a)`, and `R = V / (2 π)` in a period of one.
    let radius = 1.0 / (6.0 * PI * TAU);
    let bar = result.error_estimate.integration.unwrap();
    let widest = result.pieces.iter().map(|piece| piece.to - piece.from);
    let angle = TAU * widest.fold(0.0, f64::max);
    assert!(angle > 0.3, "a step of some length: {angle}");
    for k in 0..=200 {
        let s = f64::from(k) / 200.0;
        let state = result.state(scene.articulation(), s).unwrap();
        let found = state.frames[0].translation.vector;
        let exact = radius * Vector3::new((TAU * s).sin(), 1.0 - (TAU * s).cos(), 0.0);
        let interpolation = radius * angle.powi(4) / 384.0;
        within(
            (found - exact).norm(),
            interpolation + bar,
            format!("both errors at {s}"),
        );
    }
}

/// The nodes of a step over ten periods fall on whole periods, where the force is the same.
#[test]
fn bug_the_runge_kutta_pair_stepped_over_periods_of_loads() {
    let text = r#"
        model.kind = "rpy"
        bodies = [{ name = "a", radius = 1, position = [0, 0, 0], force = {
            amplitude = [1, 0, 0], phase = 1.5707963267948966, period = 0.1 } }]
        gait.phases = [{ duration = 36 }]
    "#;
    let scene = Scene::parse(text).unwrap();
    let mut model = swimmer::choose(&scene).unwrap().model;
    let outcome = testkit::run_by(model.as_mut(), Method::RungeKutta);
    let bar = outcome.error_estimate.integration.unwrap();
    within(
        outcome.displacement[0].norm(),
        bar + 1e-12,
        "the sum over whole periods is zero",
    );
    // The amplitude of the motion, F/(6π μ a) over 2π/0.1.
    assert!(bar < 0.1 / (TAU * 6.0 * PI), "{bar:e}");
}

/// Spheres that settle beside each other and repel each other, by the method that the scene
/// chooses and by collocation.
#[test]
fn many_repelling_spheres_move_alike_by_the_pair_and_by_collocation() {
    let sphere = |k: usize| {
        let [x, y, z] = [k % 3, k / 3 % 2, k / 6].map(|n| 2.3 * n as f64);
        format!(
            "[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = [{x:?}, {:?}, {z:?}]\n\
             force = [0, 0, -{:?}]\n",
            y + 0.1 * x,
            10.0 + k as f64
        )
    };
    let bodies: String = (0..12).map(sphere).collect();
    let text = format!(
        "model = {{ kind = \"rpy\", tolerance = 1e-4, estimates = \"off\" }}\n\
         contact = {{ range = 0.1, strength = 2 }}\ngait.phases = [{{ duration = 0.5 }}]\n\
         output.samples = 7\n{bodies}"
    );
    let scene = Scene::parse(&text).unwrap();
    let method = Method::from_scene(&scene);
    assert_eq!(method, Method::RungeKutta);
    let mut model = swimmer::choose(&scene).unwrap().model;
    let [pair, collocation] =
        [method, Method::Collocation].map(|method| testkit::run_by(model.as_mut(), method));
    let bars = [&pair, &collocation].map(|run| run.error_estimate.integration.unwrap());
    for (one, other) in pair.displacement.iter().zip(&collocation.displacement) {
        within((one - other).norm(), bars[0] + bars[1], "both bars");
    }
    let rows = pair
        .uniform_samples
        .iter()
        .zip(&collocation.uniform_samples);
    for (one, other) in rows {
        let [one, other] = [one, other].map(|row| row.bodies.as_ref().unwrap());
        for (one, other) in one.iter().zip(other) {
            // Cubics through solutions of steps that the tolerance 1e-4 allows.
            within(
                (one.velocity - other.velocity).norm(),
                1e-3,
                "interpolation",
            );
        }
    }
    let times: Vec<f64> = pair.samples.iter().map(|sample| sample.time).collect();
    // The row of the start has no velocities, the solution there has.
    assert!(times[1..].is_sorted_by(|a, b| a < b), "{times:?}");
}
