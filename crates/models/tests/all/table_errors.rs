//! Error bars of tables over shape space.

use models::{
    BodySolution, DiscretisationError, ErrorEstimate, Hydrodynamics, ShapeSpace, SphereModel,
    SpheresModel, Uncertainty,
};
use nalgebra::Vector3;
use scene::Scene;
use testkit::{Recording, SceneText, within};

use crate::scenes::three_spheres;

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

/// A model with known error bars, among them those of a mesh.
fn with_bars(scene: &Scene) -> Recording<'static> {
    let model = SpheresModel::new(scene, SphereModel::Rpy).unwrap();
    Recording::changing(model, |query, solutions| {
        let shape = query.configuration.shape;
        for (solution, rates) in solutions.iter_mut().zip(query.rates) {
            solution.error_estimate = ErrorEstimate {
                model: Some(MODEL),
                algebraic: Some(ALGEBRAIC),
                ..ErrorEstimate::default()
            };
            let velocity = frame_error(shape) * rates.iter().sum::<f64>();
            let mut response = &solution.response * 0.0;
            response.motion.frames[0].linear = velocity;
            for (error, body) in response.bodies.iter_mut().zip(&solution.bodies) {
                let force = MESH_FORCE * body.force;
                *error = BodySolution {
                    velocity,
                    force,
                    ..BodySolution::default()
                };
            }
            let uncertainty = Uncertainty {
                relative: RELATIVE,
                velocity: uncertainty(shape),
                ..Uncertainty::default()
            };
            solution.correct(DiscretisationError {
                response,
                uncertainty,
            });
            solution.power_error.model = Some(POWER * solution.power());
        }
    })
}

#[test]
fn a_table_has_the_largest_bars_of_its_points_and_its_own_interpolation_error() {
    let scene = three_spheres().scene();
    let mut model = with_bars(&scene);
    let ranges = [(6.0, 10.0), (6.0, 10.0)];
    let space = ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-5).unwrap();
    let (interpolation, of_points) = space.errors();
    assert!(interpolation > 0.0);
    within(interpolation, 1e-4, "ten tolerances");
    let largest_uncertainty = uncertainty(&[10.0, 10.0]);
    let expected = MODEL + ALGEBRAIC + largest_uncertainty;
    within(of_points / expected - 1.0, 1e-13, "rounding");

    let state = scene.initial_state();
    let shape = [6.9, 8.3];
    let configuration = testkit::at(&state, &shape);
    for rates in [[1.0, 0.0], [0.5, -2.0], [-1.0, 1.0]] {
        let found = space.solution(configuration, &rates).unwrap();
        // Errors add up in whatever direction the arms move.
        let speed: f64 = rates.iter().map(|rate: &f64| rate.abs()).sum();
        let bar = found.error_estimate.model.unwrap();
        let expected = speed * (interpolation + MODEL + ALGEBRAIC);
        within(bar / expected - 1.0, 1e-13, "rounding");

        let error = found.mesh_error.as_ref().unwrap();
        let expected = frame_error(&shape) * (rates[0] + rates[1]);
        let difference = (error.motion.frames[0].linear - expected).norm();
        within(
            difference,
            speed * interpolation.min(1e-9),
            "a linear function is exact",
        );
        let expected = speed * largest_uncertainty;
        within(
            error.uncertainty.velocity / expected - 1.0,
            1e-13,
            "rounding",
        );
        assert_eq!(error.uncertainty.relative, RELATIVE);
        let power = found.power();
        let removed = (found.uncorrected_power() - power).abs();
        let bar = found.power_error.mesh.unwrap();
        assert!(removed > 0.0);
        within(
            bar / (RELATIVE * removed) - 1.0,
            1e-9,
            "a difference of powers",
        );

        // The bar of the power contains that of the points, and the difference from the model.
        let exact = model.solve_one(configuration, &rates).unwrap().power();
        let bar = found.power_error.model.unwrap();
        let own = bar - POWER * power;
        assert!(own > 0.0);
        within(power - exact, own, "the error bar");
        within(own, 1e-2 * power, "the bar says something");
    }
}

/// Arms that are clamped to the spheres exert torques on them.
#[test]
fn the_metric_contains_the_power_of_torques() {
    let scene = SceneText::new()
        .sphere("hub", 1.0, [0; 3])
        .sphere("right", 1.0, [5, 0, 0])
        .sphere("up", 1.5, [0, 6, 0])
        .slide("one", "right", "hub")
        .slide("two", "up", "hub")
        .scene();
    let mut model = SpheresModel::new(&scene, SphereModel::Rpy).unwrap();
    let ranges = [(4.0, 6.0), (6.0, 6.0)];
    let space = ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-9).unwrap();
    let (shape, state) = ([4.7, 6.0], scene.initial_state());
    let configuration = testkit::at(&state, &shape);
    let exact = model.solve_one(configuration, &[1.0, 0.0]).unwrap();
    let torques = exact
        .bodies
        .iter()
        .map(|b| b.torque.dot(&b.angular_velocity));
    assert!(torques.sum::<f64>().abs() > 1e-4 * exact.power());
    let metric = space.metric(&shape).unwrap();
    within(
        metric[(0, 0)] / exact.power() - 1.0,
        1e-7,
        "the tolerance, of powers of about 20",
    );
}
