//! Accuracy and cost of the integration methods.

use approx::assert_abs_diff_eq;
use nalgebra::Vector3;
use rigid::{StateVelocity, Twist};
use swimmer::models::{
    BodySolution, Configuration, Cost, DiscretisationError, Hydrodynamics, InstantaneousSolution,
    ModelError, Query, SphereModel, SpheresModel, Uncertainty,
};
use swimmer::{Method, Scene, spans};

use crate::strokes::{FREE, follow, over_wall};
use crate::support::{Run, Tensor, run, run_with, scene, three_spheres};

#[test]
fn collocation_meets_its_tolerance_and_the_error_bar_holds() {
    for text in [
        |tolerance: f64| three_spheres(&format!("model.tolerance = {tolerance}"), FREE),
        |tolerance: f64| over_wall(20.0, tolerance),
        |tolerance: f64| over_wall(5.0, tolerance),
    ] {
        let exact = follow(&text(1e-11)).net(1);
        for tolerance in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
            let run = follow(&text(tolerance));
            let error = (run.net(1) - exact).norm();
            // The error bar of a phase span refers to the largest displacement of any body, so the
            // sum over the phase spans bounds the error of the net displacement.
            assert!(
                error <= run.integration_error(),
                "{error:e} > {:e}",
                run.integration_error()
            );
            assert!(
                error <= tolerance * exact.norm(),
                "{error:e} at {tolerance:e}"
            );
            assert!(run.integration_error() <= tolerance * exact.norm());
        }
    }
}

#[test]
fn a_stroke_takes_24_solves_to_1e_3_and_40_to_1e_4() {
    // Orders of one to three and of one to four points on each of four phase spans.
    for (tolerance, solves) in [(1e-3, 24), (1e-4, 40)] {
        let text = format!("model.tolerance = {tolerance}");
        assert!(follow(&three_spheres(&text, FREE)).solves() <= solves);
        assert!(follow(&over_wall(20.0, tolerance)).solves() <= solves);
    }
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
    // Halving the step halves the error, up to the next order: 1/40 relative at 20 steps per
    // phase span.
    assert_abs_diff_eq!(error(20) / error(40), 2.0, epsilon = 0.1);
    assert!(error(40) > 100.0 * (follow(&over_wall(5.0, 1e-3)).net(1) - exact).norm());
}

#[test]
fn the_runge_kutta_pair_meets_its_tolerance_and_its_error_bar_holds() {
    for text in [
        |tolerance: f64| three_spheres(&format!("model.tolerance = {tolerance}"), FREE),
        |tolerance: f64| over_wall(5.0, tolerance),
    ] {
        let exact = follow(&text(1e-11));
        let work = |run: &Run| run.spans.iter().map(|span| span.work).sum::<f64>();
        let (exact, exact_work) = (exact.net(1), work(&exact));
        let mut solves = 0;
        for tolerance in [1e-2, 1e-4, 1e-6, 1e-8] {
            let run = run(&scene(&text(tolerance)), Tensor::Rpy, Method::RungeKutta).unwrap();
            let error = (run.net(1) - exact).norm();
            // The estimate is the error of the less accurate formula and bounds that of the other.
            assert!(
                error <= run.integration_error(),
                "{error:e} at {tolerance:e}"
            );
            assert!(
                error <= tolerance * exact.norm(),
                "{error:e} at {tolerance:e}"
            );
            assert!(run.integration_error() <= tolerance * exact.norm());
            let bars = run
                .spans
                .iter()
                .map(|span| span.work_error.integration.unwrap());
            let (bar, error) = (bars.sum::<f64>(), (work(&run) - exact_work).abs());
            assert!(
                error <= bar && bar <= 10.0 * tolerance * exact_work,
                "work: {error:e} {bar:e} at {tolerance:e}"
            );
            assert!(run.solves() >= solves);
            solves = run.solves();
        }
        // Order five: a tolerance smaller by a factor of a million needs 16 times as many steps.
        assert!(solves < 1000, "{solves}");
    }
}

/// A model whose discretisation errors rotate with the swimmer.
struct WithDiscretisationError(SpheresModel);

impl Hydrodynamics for WithDiscretisationError {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn scene(&self) -> &Scene {
        self.0.scene()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let mut solutions = self.0.solve(query)?;
        let rotation = query.configuration.state.frames[0].rotation;
        let vector = |k: usize| rotation * Vector3::new(1.0, 2.0, k as f64);
        for solution in &mut solutions {
            let bodies = solution.bodies.len();
            // Before the correction everything is larger by these vectors.
            let mut error = DiscretisationError {
                motion: StateVelocity {
                    frames: vec![Twist {
                        linear: vector(3),
                        angular: vector(4),
                    }],
                    spins: (0..bodies).map(|body| vector(5 + body)).collect(),
                    joints: vec![],
                },
                bodies: (0..bodies)
                    .map(|body| BodySolution {
                        velocity: vector(10 + body),
                        angular_velocity: vector(15 + body),
                        force: vector(20 + body),
                        torque: vector(25 + body),
                    })
                    .collect(),
                joint_forces: (0..2).map(|joint| vector(30 + joint)).collect(),
                slip_power: 0.0,
                uncertainty: Uncertainty::default(),
            };
            let exact = solution.clone();
            solution.correct(error.clone());
            let shifted = DiscretisationError::between(&exact, solution, Uncertainty::default());
            assert!((shifted.bodies[1].torque - error.bodies[1].torque).norm() < 1e-12);
            *solution = exact;
            error.uncertainty.relative = 0.5;
            solution.mesh_error = Some(error);
        }
        Ok(solutions)
    }

    fn cost(&mut self, configuration: Configuration<'_>) -> Result<Cost, ModelError> {
        self.0.cost(configuration)
    }
}

/// All vectors of a solution.
fn vectors(solution: &InstantaneousSolution) -> Vec<Vector3<f64>> {
    let error = solution.mesh_error.as_ref().unwrap();
    let bodies = solution.bodies.iter();
    let motions = [&solution.motion, &error.motion];
    let frames = motions.into_iter().flat_map(|motion| &motion.frames);
    let spins = motions.into_iter().flat_map(|motion| &motion.spins);
    bodies
        .chain(&error.bodies)
        .flat_map(|b| [b.velocity, b.angular_velocity, b.force, b.torque])
        .chain(
            solution
                .joint_forces
                .iter()
                .chain(&error.joint_forces)
                .copied(),
        )
        .chain(spins.copied())
        .chain(frames.flat_map(|frame| [frame.linear, frame.angular]))
        .collect()
}

/// Solutions of a phase span are rotated to the corrected path, on which they belong to their
/// states.
#[test]
fn solutions_of_a_rotating_swimmer_are_the_solutions_at_their_states() {
    let text = include_str!("../../templates/planar.toml");
    let scene = scene(text);
    let model = || WithDiscretisationError(SpheresModel::new(&scene, SphereModel::Rpy).unwrap());
    let run = run_with(&scene, &mut model(), Method::Collocation).unwrap();
    let all = spans(scene.gait(), scene.articulation().initial_shape()).unwrap();
    let mut largest_angle = 0.0_f64;
    for (span, result) in all.zip(&run.spans) {
        for found in &result.solutions {
            let shape = span.shape(found.s);
            let configuration = Configuration {
                state: &found.state,
                shape: &shape,
            };
            let exact = model()
                .solve_one(configuration, &span.rates(found.s))
                .unwrap();
            let (found, exact) = (vectors(&found.solution), vectors(&exact));
            assert_eq!(found.len(), exact.len());
            for (found, exact) in found.iter().zip(&exact) {
                // Velocities are of order one, forces and errors of order ten; rounding is
                // amplified by the condition number of the resistance, below 100.
                let difference = (found - exact).norm();
                assert!(difference < 1e-12, "{difference:e}");
            }
        }
        largest_angle = largest_angle.max(result.end.frames[0].rotation.angle());
    }
    assert!(largest_angle > 0.01, "{largest_angle}");
}
