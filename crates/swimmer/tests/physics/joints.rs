//! Joints that turn, in three-dimensional elements.

use nalgebra::{Matrix6, Vector3, Vector6};
use rigid::ExternalLoad;
use swimmer::models::{BodyInertia, InstantaneousSolution, Query};
use testkit::{SceneText, boxed, exact, run, within};

/// Purcell's swimmer of three spheroids 2:1 whose hinges are 3 from the centres: displacement per
/// cycle and work by the method of fundamental solutions (three levels, last digit 1).
#[test]
#[ignore = "slow: 60 s"]
fn purcells_swimmer_is_exact_within_its_bars() {
    let outcome = run(&SceneText::file(include_str!("../../templates/purcell.toml")).scene());
    let [net, work] = exact::PURCELL;
    let bar = outcome.error_estimate.total();
    let off = outcome.displacement[1] - Vector3::new(net.value, 0.0, 0.0);
    within(off.norm(), bar + 1e-6, "the error bar and the last digit");
    within(bar, 5e-3 * net.value.abs(), "the bar says something");
    let missed = outcome.work - work.value;
    within(
        missed,
        outcome.work_error.total() + 1e-3,
        "the error bar and the last digit",
    );
    within(outcome.rotation.norm(), 1e-3, "the mesh is not symmetric");
}

/// All formulations impose hinges, screws, springs, dashpots and masses alike, with a direct
/// solver.
#[test]
#[ignore = "slow: 6 s"]
fn formulations_agree_for_hinges_and_springs() {
    let screw =
        "joint = \"screw\", pitch = 2, drive = \"spring\", stiffness = 3, rest = 0.4, damping = 2";
    let middle = "shape = \"spheroid\", radius = 0.8, half_length = 1.2, axis = [1, 0.2, 0]";
    let hinge = "joint = \"hinge\", axis = [0.2, 0, 1], pivot = [-1.7, 0, 0]";
    let text = SceneText::new()
        .sphere("tail", 1.0, [-3.5, 0.5, 0.2])
        .shape("middle", middle, [0; 3])
        .shape(
            "head",
            "radius = 1, force = [0.3, 0.1, 0.2]",
            [3.5, 0.0, 0.0],
        )
        .sphere("sensor", 0.7, [0, 4, 0])
        .joint("hinge", "tail", "middle", hinge)
        .joint("screw", "head", "middle", screw)
        .joint("ball", "sensor", "middle", "joint = \"ball\"")
        .phases(&[("hinge", -1.0)])
        .ball(9.0)
        .elements(1.2)
        .set(&["fem.solver=direct", "fem.estimates=off"]);
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
        let scene = text.clone().with("fem.formulation", formulation).scene();
        let (state, rates) = (scene.initial_state(), [vec![-1.0, 0.0, 0.0]]);
        let shape = scene.articulation().initial_shape();
        let configuration = testkit::at(&state, shape);
        let query = Query::new(configuration, &rates).with_inertia(&inertia);
        boxed(&scene).solve(&query).unwrap().remove(0)
    });
    let [first, others @ ..] = solved;
    let vectors = |solution: &InstantaneousSolution| -> Vec<Vector3<f64>> {
        let bodies = solution.bodies.iter();
        let of_bodies = bodies.flat_map(|b| [b.velocity, b.angular_velocity, b.force, b.torque]);
        of_bodies
            .chain((solution.joint_loads.iter()).flat_map(|load| [load.force, load.torque]))
            .collect()
    };
    for other in &others {
        for (a, b) in vectors(&first).iter().zip(vectors(other)) {
            within(
                (a - b).norm(),
                1e-9 * (1.0 + a.norm()),
                "rounding of the direct solver",
            );
        }
    }
    // What accelerates the set, and loads on it, balances the forces on the fluid.
    let forces: Vector3<f64> = first.bodies.iter().map(|body| body.force).sum();
    let accelerating = first.bodies.iter().zip(&inertia).map(|(body, inertia)| {
        inertia.damping.fixed_view::<3, 3>(0, 0) * body.velocity - inertia.load.force
    });
    let accelerating: Vector3<f64> = accelerating.sum();
    let external = Vector3::new(0.3, 0.1, 0.2);
    within(
        (forces + accelerating - external).norm(),
        1e-8,
        "rounding of the direct solver",
    );
    // The hinge turns at the asked rate, and the screw advances by 2 per turn.
    let [tail, middle, head] = [0, 1, 2].map(|body| &first.bodies[body]);
    let axis = Vector3::new(0.2, 0.0, 1.0).normalize();
    let hinge = tail.angular_velocity - middle.angular_velocity;
    within((hinge + axis).norm(), 1e-9, "rounding of the direct solver");
    let screw = head.angular_velocity - middle.angular_velocity;
    assert!(screw.x.abs() > 1e-3 && screw.yz().norm() < 1e-9, "{screw}");
    let with_middle = middle.velocity + middle.angular_velocity.cross(&Vector3::new(3.5, 0.0, 0.0));
    let advance = head.velocity - with_middle - screw / std::f64::consts::PI;
    within(advance.norm(), 1e-9, "rounding of the direct solver");
}
