//! Error bars of tables over shape space.

use models::{
    BodySolution, Configuration, DiscretisationError, ErrorEstimate, Hydrodynamics,
    InstantaneousSolution, ModelError, Query, Response, ShapeSpace, SphereModel, SpheresModel,
    Uncertainty,
};
use nalgebra::Vector3;
use rigid::{StateVelocity, Twist};
use scene::Scene;

use crate::scenes::three_spheres;

/// A model with known error bars, among them those of a mesh.
struct WithBars(SpheresModel);

/// Error bars of the velocity for a unit rate, without that of the mesh.
const MODEL: f64 = 1e-4;
const ALGEBRAIC: f64 = 2e-4;
/// The error of the power by the model, and of forces by the mesh, relative to them.
const POWER: f64 = 1e-3;
const MESH_FORCE: f64 = -0.01;
/// Relative uncertainty of the discretisation errors.
const RELATIVE: f64 = 0.2;

/// Discretisation error of the frame for a unit rate.
fn frame_error(shape: &[f64]) -> Vector3<f64> {
    Vector3::new(1e-6, 1e-7 * shape[0], -1e-7 * shape[1])
}

/// Uncertainty of that error: largest for the longest arms.
fn uncertainty(shape: &[f64]) -> f64 {
    1e-6 * (shape[0] + shape[1])
}

impl Hydrodynamics for WithBars {
    fn name(&self) -> &'static str {
        "with bars"
    }

    fn scene(&self) -> &Scene {
        self.0.scene()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let shape = query.configuration.shape;
        let mut solutions = self.0.solve(query)?;
        for (solution, rates) in solutions.iter_mut().zip(query.rates) {
            solution.error_estimate = ErrorEstimate {
                model: Some(MODEL),
                algebraic: Some(ALGEBRAIC),
                ..ErrorEstimate::default()
            };
            let error = frame_error(shape) * rates.iter().sum::<f64>();
            solution.correct(DiscretisationError {
                response: Response {
                    motion: StateVelocity {
                        frames: vec![Twist {
                            linear: error,
                            angular: Vector3::zeros(),
                        }],
                        spins: vec![Vector3::zeros(); 3],
                        joints: vec![],
                    },
                    bodies: (solution.bodies.iter())
                        .map(|body| BodySolution {
                            velocity: error,
                            force: MESH_FORCE * body.force,
                            ..BodySolution::default()
                        })
                        .collect(),
                    joint_forces: vec![Vector3::zeros(); solution.joint_forces.len()],
                    slip_power: 0.0,
                },
                uncertainty: Uncertainty {
                    relative: RELATIVE,
                    velocity: uncertainty(shape),
                    power: 0.0,
                },
            });
            solution.power_error.model = Some(POWER * solution.power());
        }
        Ok(solutions)
    }
}

#[test]
fn a_table_has_the_largest_bars_of_its_points_and_its_own_interpolation_error() {
    let scene = three_spheres("");
    let mut model = WithBars(SpheresModel::new(&scene, SphereModel::Rpy).unwrap());
    let ranges = [(6.0, 10.0), (6.0, 10.0)];
    let space = ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-5).unwrap();
    let (interpolation, of_points) = space.errors();
    assert!(
        interpolation > 0.0 && interpolation < 1e-4,
        "{interpolation:e}"
    );
    let largest_uncertainty = uncertainty(&[10.0, 10.0]);
    let expected = MODEL + ALGEBRAIC + largest_uncertainty;
    assert!((of_points / expected - 1.0).abs() < 1e-13, "{of_points:e}");

    let state = scene.initial_state();
    let shape = [6.9, 8.3];
    let configuration = Configuration {
        state: &state,
        shape: &shape,
    };
    for rates in [[1.0, 0.0], [0.5, -2.0], [-1.0, 1.0]] {
        let found = space.solution(configuration, &rates).unwrap();
        // Errors add up in whatever direction the arms move.
        let speed: f64 = rates.iter().map(|rate: &f64| rate.abs()).sum();
        let bar = found.error_estimate.model.unwrap();
        let expected = speed * (interpolation + MODEL + ALGEBRAIC);
        assert!((bar / expected - 1.0).abs() < 1e-13, "{bar:e} {expected:e}");

        let error = found.mesh_error.as_ref().unwrap();
        let expected = frame_error(&shape) * (rates[0] + rates[1]);
        let difference = (error.motion.frames[0].linear - expected).norm();
        assert!(
            difference <= speed * interpolation.min(1e-9),
            "{difference:e}"
        );
        let expected = speed * largest_uncertainty;
        assert!((error.uncertainty.velocity / expected - 1.0).abs() < 1e-13);
        assert_eq!(error.uncertainty.relative, RELATIVE);
        let power = found.power();
        let removed = (found.uncorrected_power() - power).abs();
        let bar = found.power_error.mesh.unwrap();
        assert!(removed > 0.0 && (bar / (RELATIVE * removed) - 1.0).abs() < 1e-9);

        // The bar of the power contains that of the points, and the difference from the model.
        let exact = model.solve_one(configuration, &rates).unwrap().power();
        let bar = found.power_error.model.unwrap();
        let own = bar - POWER * power;
        assert!(
            own > 0.0 && (power - exact).abs() <= own,
            "{own:e} {power} {exact}"
        );
        assert!(own < 1e-2 * power, "{own:e} {power}");
    }
}

/// Arms that are clamped to the spheres exert torques on them.
#[test]
fn the_metric_contains_the_power_of_torques() {
    let scene = Scene::parse(
        r#"
        bodies = [
            { name = "hub", radius = 1, position = [0, 0, 0] },
            { name = "right", radius = 1, position = [5, 0, 0] },
            { name = "up", radius = 1.5, position = [0, 6, 0] },
        ]
        links = [
            { name = "one", body = "right", to = "hub" },
            { name = "two", body = "up", to = "hub" },
        ]
        "#,
    )
    .unwrap();
    let mut model = SpheresModel::new(&scene, SphereModel::Rpy).unwrap();
    let ranges = [(4.0, 6.0), (6.0, 6.0)];
    let space = ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-9).unwrap();
    let (shape, state) = ([4.7, 6.0], scene.initial_state());
    let configuration = Configuration {
        state: &state,
        shape: &shape,
    };
    let exact = model.solve_one(configuration, &[1.0, 0.0]).unwrap();
    let torques = exact
        .bodies
        .iter()
        .map(|b| b.torque.dot(&b.angular_velocity));
    assert!(torques.sum::<f64>().abs() > 1e-4 * exact.power());
    let metric = space.metric(&shape).unwrap();
    assert!(
        (metric[(0, 0)] / exact.power() - 1.0).abs() < 1e-7,
        "{metric}"
    );
}
