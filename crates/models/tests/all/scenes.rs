//! Scenes and solutions that several tests use.

use models::{
    AxisymmetricModel, BodySolution, ErrorEstimate, FemModel, Hydrodynamics, InstantaneousSolution,
    Query, SphereModel, SpheresModel,
};
use nalgebra::Vector3;
use scene::Scene;
use testkit::{SceneText, solve_at};

/// Three spheres with two arms of length 10, without a gait.
pub fn three_spheres() -> SceneText {
    testkit::three_spheres().without_phases()
}

/// Three spheres in a ball, with coarse elements.
pub fn three_spheres_in_ball() -> Scene {
    three_spheres()
        .ball(30.0)
        .with("fem.surface_size", 1.2)
        .scene()
}

/// The solution of a model at the start of its scene.
pub fn solve_at_start(model: &mut dyn Hydrodynamics, rates: &[f64]) -> InstantaneousSolution {
    let shape = model.scene().articulation().initial_shape().to_vec();
    solve_at(model, &shape, rates)
}

/// The largest errors over all bodies and that of the power, with their bars.
pub fn errors_and_bars(
    found: &InstantaneousSolution,
    exact: &InstantaneousSolution,
) -> [(&'static str, f64, ErrorEstimate); 5] {
    let largest = |of: fn(&BodySolution) -> Vector3<f64>| {
        let pairs = found.bodies.iter().zip(&exact.bodies);
        pairs.fold(0.0_f64, |most, (a, b)| most.max((of(a) - of(b)).norm()))
    };
    [
        ("velocity", largest(|b| b.velocity), found.error_estimate),
        (
            "angular velocity",
            largest(|b| b.angular_velocity),
            found.angular_velocity_error,
        ),
        ("force", largest(|b| b.force), found.force_error),
        ("torque", largest(|b| b.torque), found.torque_error),
        (
            "power",
            (found.power() - exact.power()).abs(),
            found.power_error,
        ),
    ]
}

/// The solution of a model at the start of its scene, at rest and with stresslets.
pub fn with_stresslets(model: &mut dyn Hydrodynamics) -> InstantaneousSolution {
    let scene = model.scene().clone();
    let state = scene.initial_state();
    let configuration = testkit::at(&state, scene.articulation().initial_shape());
    let rates = [vec![0.0; configuration.shape.len()]];
    let query = Query::new(configuration, &rates).with_stresslets();
    model.solve(&query).unwrap().remove(0)
}

/// The solution at the start of a scene, with stresslets, by expansions.
pub fn multipole(text: &SceneText) -> InstantaneousSolution {
    let kind = SphereModel::Multipole(1e-9);
    with_stresslets(&mut SpheresModel::new(&text.scene(), kind).unwrap())
}

/// The same in the meridian plane.
pub fn meridian(text: &SceneText) -> InstantaneousSolution {
    let model = AxisymmetricModel::new(&text.scene()).unwrap();
    with_stresslets(&mut model.with_accuracy(1e-9))
}

/// The same by finite elements.
pub fn elements(text: &SceneText) -> InstantaneousSolution {
    with_stresslets(&mut FemModel::new(&text.scene()).unwrap())
}
