//! Scenes and solutions that several tests use.

use models::{
    AxisymmetricModel, Configuration, FemModel, Hydrodynamics, InstantaneousSolution, Query,
    SphereModel, SpheresModel,
};
use scene::Scene;

/// Three spheres with two arms of length 10, with further lines of the scene file.
pub fn three_spheres(lines: &str) -> Scene {
    let text = format!(
        r#"
        bodies = [
            {{ name = "left", radius = 1, position = [-10, 0, 0] }},
            {{ name = "centre", radius = 1, position = [0, 0, 0] }},
            {{ name = "right", radius = 1, position = [10, 0, 0] }},
        ]
        links = [
            {{ name = "left arm", body = "left", to = "centre" }},
            {{ name = "right arm", body = "right", to = "centre" }},
        ]
        {lines}
        "#
    );
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Three spheres in a ball, with coarse elements.
pub fn three_spheres_in_ball() -> Scene {
    three_spheres("domain = { kind = \"ball\", radius = 30 }\nfem.surface_size = 1.2")
}

/// The solution of a model for a shape, with the bodies where they are at the start.
pub fn solve_at(
    model: &mut dyn Hydrodynamics,
    shape: &[f64],
    rates: &[f64],
) -> InstantaneousSolution {
    let state = &model.scene().initial_state();
    model
        .solve_one(Configuration { state, shape }, rates)
        .unwrap()
}

/// The solution of a model at the start of its scene.
pub fn solve_at_start(model: &mut dyn Hydrodynamics, rates: &[f64]) -> InstantaneousSolution {
    let shape = model.scene().articulation().initial_shape().to_vec();
    solve_at(model, &shape, rates)
}

/// The solution of a model at the start of its scene, at rest and with stresslets.
pub fn with_stresslets(model: &mut dyn Hydrodynamics) -> InstantaneousSolution {
    let scene = model.scene().clone();
    let configuration = Configuration {
        state: &scene.initial_state(),
        shape: scene.articulation().initial_shape(),
    };
    let rates = [vec![0.0; configuration.shape.len()]];
    let query = Query::new(configuration, &rates).with_stresslets();
    model.solve(&query).unwrap().remove(0)
}

/// The solution at the start of a scene, with stresslets, by expansions.
pub fn multipole(text: &str) -> InstantaneousSolution {
    let scene = Scene::parse(text).unwrap();
    with_stresslets(&mut SpheresModel::new(&scene, SphereModel::Multipole(1e-9)).unwrap())
}

/// The same in the meridian plane.
pub fn meridian(text: &str) -> InstantaneousSolution {
    let model = AxisymmetricModel::new(&Scene::parse(text).unwrap()).unwrap();
    with_stresslets(&mut model.with_accuracy(1e-9))
}

/// The same by finite elements.
pub fn elements(text: &str) -> InstantaneousSolution {
    with_stresslets(&mut FemModel::new(&Scene::parse(text).unwrap()).unwrap())
}
