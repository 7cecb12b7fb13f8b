//! Superposed solutions of a rigid body in a linear flow against those of the model.

use models::{Configuration, ErrorEstimates, FemModel, Hydrodynamics, Query, Superposed};
use nalgebra::{UnitQuaternion, Vector3};
use scene::Scene;

/// A spheroid that sinks, swims by slip and is sheared, away from the origin.
const SPHEROID: &str = "gravity = [0, 0, -2]\nfem = { size_factor = 2 }\n\
    background = { kind = \"shear\", gradient = [[0.3, 1, 0], [0, -0.3, 0], [0.5, 0, 0]] }\n\
    [[bodies]]\nname = \"s\"\nshape = \"spheroid\"\nradius = 1\nhalf_length = 2\n\
    axis = [1, 0, 0]\nposition = [1, -2, 0.5]\ndensity = 2\n\
    torque = [0, 0, 3]\nslip = { b1 = 1, b2 = 0.5, axis = [1, 0, 0] }\n";

#[test]
fn superposed_solutions_are_those_of_the_model() {
    let scene = Scene::parse(SPHEROID).unwrap();
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
        let configuration = Configuration {
            state: &state,
            shape: &[],
        };
        model.solve_one(configuration, &[]).unwrap();
    }
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.4, -1.1, 0.7));
    state.frames[0].rotation = turn * state.frames[0].rotation;
    state.attitudes[0] = turn * state.attitudes[0];
    state.frames[0].translation.vector += Vector3::new(0.3, 0.2, -4.0);
    let configuration = Configuration {
        state: &state,
        shape: &[],
    };
    let rates = [vec![]];
    let query = Query::new(configuration, &rates).with_flows(true);
    let a = direct.solve(&query).unwrap().pop().unwrap();
    let b = superposed.solve(&query).unwrap().pop().unwrap();
    // Corrections take a fixed number of iterations, which is not linear: a hundredth of them.
    let change = (a.bodies[0].velocity - b.bodies[0].velocity).norm();
    assert!(change < a.error_estimate.mesh.unwrap(), "{change}");
    // Relative residuals are 1e-8, the condition number costs some digits.
    let close = |a: &Vector3<f64>, b: &Vector3<f64>, scale: f64| {
        assert!((a - b).norm() < 1e-5 * scale, "{a} {b}");
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
        assert!((a - b).norm() < 1e-3 * scale, "{a} {b}");
    };
    let [flow, combined] = flows.map(|flow| flow.unwrap().into_field().unwrap());
    assert_eq!(flow.velocity.len(), combined.velocity.len());
    let largest = flow.velocity.iter().map(|u| u.norm()).fold(0.0, f64::max);
    for (k, x) in flow.mesh.points().iter().enumerate() {
        assert!((x - combined.mesh.points()[k]).norm() < 1e-9 * (1.0 + x.norm()));
        close(&flow.velocity[k], &combined.velocity[k], largest);
    }
}

/// In a symmetry plane of the model the body turns about the normal only, and fewer solutions are
/// superposed.
#[test]
fn a_squirmer_in_a_symmetry_plane_is_superposed_from_orientations_in_it() {
    let text = "fem = { size_factor = 2 }\n\
        background = { kind = \"shear\", gradient = [[0, 1, 0], [0, 0, 0], [0, 0, 0]] }\n\
        [[bodies]]\nname = \"s\"\nradius = 1\nposition = [0.3, -0.2, 0]\n\
        torque = [0, 0, 3]\nslip = { b1 = 1.5, b2 = 1, axis = [0.6, 0.8, 0] }\n";
    let scene = Scene::parse(text).unwrap();
    assert_eq!(scene.fem_symmetry_planes(), [false, false, true]);
    assert_eq!(Superposed::count(&scene), Some(3));
    let mut model = Superposed::new(Box::new(FemModel::new(&scene).unwrap()))
        .ok()
        .unwrap();
    let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.0, 0.0, 2.3));
    let mut state = scene.initial_state();
    state.attitudes[0] = turn * state.attitudes[0];
    state.frames[0].rotation = turn * state.frames[0].rotation;
    let shape = &[];
    let state = &state;
    let found = model
        .solve_one(Configuration { state, shape }, &[])
        .unwrap();
    assert_eq!(model.capabilities().error_estimates, ErrorEstimates::Always);
    // U = 2 B1 e / 3 + u(x) and ω = curl u / 2 + T / 8 π of a sphere in unbounded fluid.
    let speed = turn * Vector3::new(0.6, 0.8, 0.0) + Vector3::new(-0.2, 0.0, 0.0);
    let spin = Vector3::z() * (3.0 / (8.0 * std::f64::consts::PI) - 0.5);
    let bar = found.error_estimate.total();
    let error = (found.bodies[0].velocity - speed).norm();
    assert!(error < bar && bar < 0.05, "{error:e} {bar:e}");
    let error = (found.bodies[0].angular_velocity - spin).norm();
    assert!(error < bar, "{error:e} {bar:e}");
}

#[test]
fn other_scenes_are_left_to_the_model() {
    let refused = |from: &str, to: &str| {
        let text = SPHEROID.replace(from, to);
        assert_ne!(text, SPHEROID);
        let scene = Scene::parse(&text).unwrap();
        Superposed::count(&scene).is_none()
            && Superposed::new(Box::new(FemModel::new(&scene).unwrap())).is_err()
    };
    // walls
    let strain =
        "background = { kind = \"shear\", gradient = [[0.3, 1, 0], [0, -0.3, 0], [0.5, 0, 0]] }";
    assert!(refused(strain, "domain = { kind = \"ball\", radius = 9 }"));
    // another body
    let other = "\n[[bodies]]\nname = \"t\"\nradius = 1\nposition = [6, 0, 0]\n[[bodies]]\n";
    assert!(refused("\n[[bodies]]\n", other));
    // nothing that drives it
    let still = Scene::parse("[[bodies]]\nname = \"s\"\nradius = 1\nposition = [0, 0, 0]\n");
    let model = Box::new(FemModel::new(&still.unwrap()).unwrap());
    assert!(Superposed::new(model).is_err());
}
