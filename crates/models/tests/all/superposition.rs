//! Superposed solutions of a rigid body in a linear flow against those of the model.

use models::{Configuration, ErrorEstimates, FemModel, Hydrodynamics, Query, Superposed};
use nalgebra::{UnitQuaternion, Vector3};
use testkit::{SceneText, solve_at, within};

/// A spheroid that sinks, swims by slip and is sheared, away from the origin.
fn spheroid() -> SceneText {
    let shape = "shape = \"spheroid\", radius = 1, half_length = 2, axis = [1, 0, 0], density = 2";
    let slip = "slip = { b1 = 1, b2 = 0.5, axis = [1, 0, 0] }, torque = [0, 0, 3]";
    let text = SceneText::new().shape("s", &format!("{shape}, {slip}"), [1.0, -2.0, 0.5]);
    text.with("gravity", "[0, 0, -2]")
        .with("fem.size_factor", 2)
}

/// The spheroid in a shear flow.
fn sheared() -> SceneText {
    let gradient = "[[0.3, 1, 0], [0, -0.3, 0], [0.5, 0, 0]]";
    spheroid().with(
        "background",
        format!("{{ kind = \"shear\", gradient = {gradient} }}"),
    )
}

#[test]
fn superposed_solutions_are_those_of_the_model() {
    let scene = sheared().scene();
    let fem = || Box::new(FemModel::new(&scene).unwrap());
    let mut direct = fem();
    let mut superposed = Superposed::new(fem()).ok().unwrap();
    // gravity and torque along one direction, strain and slip
    assert_eq!(Superposed::count(&scene), Some(3 + 5 + 1));
    assert_eq!(
        superposed.capabilities().error_estimates,
        ErrorEstimates::Always
    );
    let mut state = scene.initial_state();
    // A mesh that is generated in another place has other cells.
    for model in [&mut *direct as &mut dyn Hydrodynamics, &mut superposed] {
        solve_at(model, &[], &[]);
    }
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -1.1, 0.7));
    state.frames[0].rotation = turn * state.frames[0].rotation;
    state.attitudes[0] = turn * state.attitudes[0];
    state.frames[0].translation.vector += Vector3::new(0.3, 0.2, -4.0);
    let configuration = testkit::at(&state, &[]);
    let rates = [vec![]];
    let query = Query::new(configuration, &rates).with_flows(true);
    let a = direct.solve(&query).unwrap().pop().unwrap();
    let b = superposed.solve(&query).unwrap().pop().unwrap();
    let change = (a.bodies[0].velocity - b.bodies[0].velocity).norm();
    let why = "corrections take a fixed number of iterations, which is not linear";
    within(change, a.error_estimate.mesh.unwrap(), why);
    let close = |a: &Vector3<f64>, b: &Vector3<f64>, scale: f64| {
        within(
            (a - b).norm(),
            1e-5 * scale,
            "residuals of 1e-8, and the condition number",
        );
    };
    let ratio = b.error_estimate.total() / a.error_estimate.total();
    let flows = [a.flow.clone(), b.flow.clone()];
    let (a, b) = (a.uncorrected(), b.uncorrected());
    let (x, y) = (&a.bodies[0], &b.bodies[0]);
    close(&x.velocity, &y.velocity, x.velocity.norm());
    close(&x.angular_velocity, &y.angular_velocity, 1.0);
    close(&x.force, &y.force, x.force.norm());
    close(&x.torque, &y.torque, x.force.norm());
    close(&a.motion.spins[0], &b.motion.spins[0], 1.0);
    let frames = [&a, &b].map(|solution| solution.motion.frames[0]);
    close(&frames[0].linear, &frames[1].linear, x.velocity.norm());
    close(&frames[0].angular, &frames[1].angular, 1.0);
    // Bars are sums of those of the nine solutions: wider, never narrower.
    assert!((0.9..8.0).contains(&ratio), "{ratio}");

    // the flow around the body, at the same place; its corrections too are not linear
    let close = |a: &Vector3<f64>, b: &Vector3<f64>, scale: f64| {
        within((a - b).norm(), 1e-3 * scale, "corrections are not linear");
    };
    let [flow, combined] = flows.map(|flow| flow.unwrap().into_field().unwrap());
    assert_eq!(flow.velocity.len(), combined.velocity.len());
    let largest = flow.velocity.iter().map(|u| u.norm()).fold(0.0, f64::max);
    for (k, x) in flow.mesh.points().iter().enumerate() {
        let moved = (x - combined.mesh.points()[k]).norm();
        within(moved, 1e-9 * (1.0 + x.norm()), "rounding");
        close(&flow.velocity[k], &combined.velocity[k], largest);
    }
}

/// In a symmetry plane of the model the body turns about the normal only, and fewer solutions are
/// superposed.
#[test]
fn a_squirmer_in_a_symmetry_plane_is_superposed_from_orientations_in_it() {
    let slip = "slip = { b1 = 1.5, b2 = 1, axis = [0.6, 0.8, 0] }";
    let keys = format!("radius = 1, torque = [0, 0, 3], {slip}");
    let shear = "{ kind = \"shear\", gradient = [[0, 1, 0], [0, 0, 0], [0, 0, 0]] }";
    let text = SceneText::new()
        .shape("s", &keys, [0.3, -0.2, 0.0])
        .with("background", shear);
    let scene = text.with("fem.size_factor", 2).scene();
    assert_eq!(scene.fem_symmetry_planes(), [false, false, true]);
    assert_eq!(Superposed::count(&scene), Some(3));
    let model = Box::new(FemModel::new(&scene).unwrap());
    let mut model = Superposed::new(model).ok().unwrap();
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, 2.3));
    let mut state = scene.initial_state();
    state.attitudes[0] = turn * state.attitudes[0];
    state.frames[0].rotation = turn * state.frames[0].rotation;
    let (state, shape) = (&state, &[]);
    let found = model
        .solve_one(Configuration::new(state, shape), &[])
        .unwrap();
    assert_eq!(model.capabilities().error_estimates, ErrorEstimates::Always);
    // U = 2 B1 e / 3 + u(x) and ω = curl u / 2 + T / 8 π of a sphere in unbounded fluid.
    let speed = turn * Vector3::new(0.6, 0.8, 0.0) + Vector3::new(-0.2, 0.0, 0.0);
    let spin = Vector3::z() * (3.0 / (8.0 * std::f64::consts::PI) - 0.5);
    let bar = found.error_estimate.total();
    let error = (found.bodies[0].velocity - speed).norm();
    within(error, bar, "the error bar");
    within(bar, 0.05, "the bar says something");
    let error = (found.bodies[0].angular_velocity - spin).norm();
    within(error, bar, "the error bar, at a radius of 1");
}

#[test]
fn other_scenes_are_left_to_the_model() {
    let walls = spheroid().ball(9.0);
    let another_body = sheared().sphere("t", 1.0, [6, 0, 0]);
    let nothing_that_drives_it = SceneText::new().sphere("s", 1.0, [0; 3]);
    for text in [&walls, &another_body] {
        assert!(Superposed::count(&text.scene()).is_none());
    }
    for text in [walls, another_body, nothing_that_drives_it] {
        let model = Box::new(FemModel::new(&text.scene()).unwrap());
        assert!(Superposed::new(model).is_err(), "{}", text.toml());
    }
}
