//! Joints that turn, in three-dimensional elements.

use nalgebra::{Matrix6, Vector3, Vector6};
use rigid::ExternalLoad;
use swimmer::models::{BodyInertia, Configuration, InstantaneousSolution, Query};
use swimmer::{Method, Scene, choose, simulate};

use super::scenes::parse;

/// Purcell's swimmer of three spheroids 2:1 whose hinges are 3 from the centres: displacement per
/// cycle and work by the method of fundamental solutions (three levels, last digit 1).
#[test]
#[ignore = "slow: 60 s"]
fn purcells_swimmer_is_exact_within_its_bars() {
    let scene = Scene::parse(include_str!("../../templates/purcell.toml")).unwrap();
    let mut model = choose(&scene).unwrap().model;
    let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ()).unwrap();
    let net = outcome.displacement[1];
    let bar = outcome.error_estimate.total();
    let exact = Vector3::new(-0.074_667, 0.0, 0.0);
    assert!((net - exact).norm() < bar + 1e-6, "{net} +- {bar}");
    assert!(bar < 5e-3 * exact.norm(), "{bar}");
    let work_bar = outcome.work_error.total();
    let missed = (outcome.work - 439.603).abs();
    assert!(missed < work_bar + 1e-3, "{} +- {work_bar}", outcome.work);
    assert!(outcome.rotation.norm() < 1e-3, "{}", outcome.rotation);
}

/// All formulations impose hinges, screws, springs, dashpots and masses alike, with a direct
/// solver.
#[test]
fn formulations_agree_for_hinges_and_springs() {
    let scene = |formulation: &str| {
        parse(&format!(
            r#"
            domain = {{ kind = "ball", radius = 9 }}
            model.kind = "fem"
            fem = {{ formulation = "{formulation}", solver = "direct", surface_size = 1.2, estimates = "off" }}
            [[bodies]]
            name = "tail"
            radius = 1
            position = [-3.5, 0.5, 0.2]
            [[bodies]]
            name = "middle"
            shape = "spheroid"
            radius = 0.8
            half_length = 1.2
            axis = [1, 0.2, 0]
            position = [0, 0, 0]
            [[bodies]]
            name = "head"
            radius = 1
            position = [3.5, 0, 0]
            force = [0.3, 0.1, 0.2]
            [[bodies]]
            name = "sensor"
            radius = 0.7
            position = [0, 4, 0]
            [[links]]
            name = "hinge"
            body = "tail"
            to = "middle"
            joint = "hinge"
            axis = [0.2, 0, 1]
            pivot = [-1.7, 0, 0]
            [[links]]
            name = "screw"
            body = "head"
            to = "middle"
            joint = "screw"
            pitch = 2
            drive = "spring"
            stiffness = 3
            rest = 0.4
            damping = 2
            [[links]]
            name = "ball"
            body = "sensor"
            to = "middle"
            joint = "ball"
            [[gait.phases]]
            link = "hinge"
            length = -1
            "#
        ))
    };
    // Masses over a time step, in addition.
    let inertia: Vec<BodyInertia> = (1..=4)
        .map(|k| {
            let k = f64::from(k);
            BodyInertia {
                damping: Matrix6::from_diagonal(&Vector6::repeat(20.0 * k)),
                load: ExternalLoad {
                    force: Vector3::new(k, 0.3, -1.0),
                    torque: Vector3::new(0.2, k, 0.1),
                },
            }
        })
        .collect();
    let solved = ["p-tilde", "lagrange", "direct-row"].map(|formulation| {
        let scene = scene(formulation);
        let mut model = choose(&scene).unwrap().model;
        let (state, rates) = (scene.initial_state(), [vec![-1.0, 0.0, 0.0]]);
        let configuration = Configuration {
            state: &state,
            shape: scene.articulation().initial_shape(),
        };
        let query = Query::new(configuration, &rates).with_inertia(&inertia);
        model.solve(&query).unwrap().remove(0)
    });
    let [first, others @ ..] = solved;
    let vectors = |solution: &InstantaneousSolution| -> Vec<Vector3<f64>> {
        let bodies = solution.bodies.iter();
        let of_bodies = bodies.flat_map(|b| [b.velocity, b.angular_velocity, b.force, b.torque]);
        of_bodies
            .chain(solution.joint_forces.iter().copied())
            .collect()
    };
    for other in &others {
        for (a, b) in vectors(&first).iter().zip(vectors(other)) {
            assert!((a - b).norm() < 1e-9 * (1.0 + a.norm()), "{a} {b}");
        }
    }
    // What accelerates the set, and loads on it, balances the forces on the fluid.
    let forces: Vector3<f64> = first.bodies.iter().map(|body| body.force).sum();
    let accelerating = first.bodies.iter().zip(&inertia).map(|(body, inertia)| {
        inertia.damping.fixed_view::<3, 3>(0, 0) * body.velocity - inertia.load.force
    });
    let accelerating: Vector3<f64> = accelerating.sum();
    let external = Vector3::new(0.3, 0.1, 0.2);
    assert!((forces + accelerating - external).norm() < 1e-8);
    // The hinge turns at the asked rate, and the screw advances by 2 per turn.
    let [tail, middle, head] = [0, 1, 2].map(|body| &first.bodies[body]);
    let axis = Vector3::new(0.2, 0.0, 1.0).normalize();
    let hinge = tail.angular_velocity - middle.angular_velocity;
    assert!((hinge + axis).norm() < 1e-9);
    let screw = head.angular_velocity - middle.angular_velocity;
    assert!(screw.x.abs() > 1e-3 && screw.yz().norm() < 1e-9, "{screw}");
    let with_middle = middle.velocity + middle.angular_velocity.cross(&Vector3::new(3.5, 0.0, 0.0));
    let advance = head.velocity - with_middle - screw / std::f64::consts::PI;
    assert!(advance.norm() < 1e-9, "{advance}");
}
