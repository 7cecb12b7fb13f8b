//! Time stepping of bodies with mass and moment of inertia.

use approx::assert_abs_diff_eq;
use nalgebra::Vector3;
use swimmer::models::{SphereModel, SpheresModel};
use swimmer::{Method, SwimError};

use crate::strokes::FREE;
use crate::support::{Run, run_with, scene, three_spheres};

/// The run of a scene with the model of spheres, which has a resistance matrix.
fn run_spheres(text: &str, method: Method) -> Result<Run, SwimError> {
    let scene = scene(text);
    run_with(
        &scene,
        &mut SpheresModel::new(&scene, SphereModel::Rpy)?,
        method,
    )
}

/// A bent chain of bodies with a given mass and moment of inertia.
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
fn light_bodies_move_like_massless_ones_and_heavy_ones_keep_their_momentum() {
    let follow = |text: &str, method| run_spheres(text, method).unwrap();
    let exact = follow(&massive(1e-9), Method::Collocation);
    let error = |steps| {
        let run = follow(&massive(1e-9), Method::BackwardEuler { steps });
        (run.net(1) - exact.net(1)).norm()
    };
    // First order.
    assert_abs_diff_eq!(error(20) / error(40), 2.0, epsilon = 0.1);
    // Equal masses that start at rest: R t / m is 1e-7, so their centre stays, up to the
    // first-order error of the rotation of the arms.
    let heavy = follow(&massive(1e9), Method::BackwardEuler { steps: 20 });
    let centre = |run: &Run| ((0..3).map(|body| run.net(body)).sum::<Vector3<f64>>() / 3.0).norm();
    let coarser = follow(&massive(1e9), Method::BackwardEuler { steps: 10 });
    assert!(centre(&heavy) < 0.02 && centre(&heavy) < 0.6 * centre(&coarser) + 1e-6);
    assert!(heavy.moves[0].iter().any(|step| step.norm() > 1.0));
}

#[test]
fn explicit_steps_with_inertia_are_refused_beyond_the_stability_limit() {
    // One sphere, J = 1: the shortest relaxation time is that of its rotation, 1/(8 pi); the limit
    // is twice that.
    let limit = 2.0 / (8.0 * std::f64::consts::PI);
    let pulled = |step: f64| {
        format!(
            "gait.phases = [{{ duration = {:?} }}]\n[[bodies]]\nname = \"a\"\nradius = 1\n\
             position = [0, 0, 0]\nforce = [1, 0, 0]\nmass = 1\ninertia = 1\n",
            50.0 * step
        )
    };
    let method = Method::ExplicitInertia { steps: 50 };
    let step = 0.99 * limit;
    let stable = run_spheres(&pulled(step), method).unwrap();
    // v_k = F/R (1 - g^k) with g = 1 - R dt / m, and a step moves by dt v_k.
    let drag = 6.0 * std::f64::consts::PI;
    let g = 1.0 - drag * step;
    let sum = g * (1.0 - g.powi(50)) / (1.0 - g);
    assert_abs_diff_eq!(stable.net(0).x, step * (50.0 - sum) / drag, epsilon = 1e-12);
    match run_spheres(&pulled(1.01 * limit), method) {
        Err(error @ SwimError::Unstable { .. }) => {
            assert_eq!(error.exit_code(), 3);
            assert!(
                error
                    .to_string()
                    .contains("take at least 51 steps per phase"),
                "{error}"
            );
        }
        other => panic!("{:?}", other.map(|run| run.net(0))),
    }
    // Integration with inertia needs a mass.
    let massless = pulled(limit).replace("mass = 1\n", "");
    assert!(matches!(
        run_spheres(&massless, Method::BackwardEuler { steps: 5 }),
        Err(SwimError::Scene(swimmer::SceneError::BadValue { .. }))
    ));
}
