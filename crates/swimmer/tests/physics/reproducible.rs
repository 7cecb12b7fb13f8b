//! The same solution with other solvers, numbers of threads and units.

use swimmer::Scene;
use swimmer::models::InstantaneousSolution;

use testkit::{start, within};

use crate::scenes::{
    bent, bodies, force_error, largest_differences, solve_with_flow, velocity_error,
};

fn same(v: [nalgebra::Vector3<f64>; 4]) -> [nalgebra::Vector3<f64>; 4] {
    v
}

/// The bent swimmer by this linear solver.
fn by_solver(solver: &str) -> Scene {
    bent(&[&format!("fem.solver={solver}")])
}

#[test]
fn direct_and_block_solver_agree() {
    let [block, direct] = ["block", "direct"].map(|solver| start(&by_solver(solver)));
    assert_eq!(
        [block.solver.solver.as_str(), &direct.solver.solver],
        ["block", "direct"]
    );
    let [velocities, forces] = largest_differences(&block, &direct, same);
    within(velocities, 1e-8, "residuals of 1e-10");
    within(
        velocities,
        velocity_error(&block) + velocity_error(&direct),
        "residuals",
    );
    within(
        forces,
        force_error(&block) + force_error(&direct),
        "residuals",
    );
}

#[test]
fn solutions_are_bitwise_equal_for_any_number_of_threads() {
    for solver in ["block", "direct"] {
        let scene = by_solver(solver);
        let answers = [1, 2, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let (instant, flow) = solve_with_flow(&scene);
                (instant.response.bodies, flow.velocity, flow.pressure)
            })
        });
        for (other, threads) in [(1, "two"), (2, "three")] {
            let is_same = answers[0] == answers[other];
            assert!(is_same, "{solver}: one and {threads} threads differ");
        }
    }
}

/// The bent swimmer with other units of length and viscosity.
fn in_units(length: f64, viscosity: f64) -> Scene {
    let text = bodies()
        .scene()
        .bodies()
        .iter()
        .fold(bodies(), |text, body| {
            let key = |key: &str| format!("bodies.{}.{key}", body.name);
            let position = body.position * length;
            text.with(
                &key("radius"),
                format!("{:?}", body.bounding_radius() * length),
            )
            .with(&key("position"), format!("{:?}", position.as_slice()))
        });
    let text = text
        .phases(&[("left-arm", 3.25 * length)])
        .ball(9.0 * length);
    let text = text.elements(0.7 * length).with("fem.rtol", "1e-10");
    text.with("fluid.viscosity", format!("{viscosity:?}"))
        .scene()
}

/// Differences of two solutions in other units: velocities scale with the length, forces with
/// viscosity and length squared.
fn scaled(
    unit: &InstantaneousSolution,
    other: &InstantaneousSolution,
    length: f64,
    viscosity: f64,
) -> [f64; 2] {
    let force = viscosity * length * length;
    let mut differences = largest_differences(unit, other, |[u, w, f, t]| {
        [u * length, w, f * force, t * (force * length)]
    });
    differences[1] /= force;
    differences
}

#[test]
fn units_of_the_scene_do_not_matter() {
    let unit = start(&in_units(1.0, 1.0));
    // A power of two changes no digit.
    let length = 0.5_f64.powi(20);
    let other = start(&in_units(length, 2.0));
    assert_eq!(scaled(&unit, &other, length, 2.0), [0.0, 0.0]);
    // Micrometres and water change the last digits, also those of the mesh: as two different
    // solves.
    let (length, viscosity) = (1e-6, 1e-3);
    let other = start(&in_units(length, viscosity));
    let [velocities, forces] = scaled(&unit, &other, length, viscosity);
    // Rates are lengths per time as well; angular velocities keep their size.
    within(velocities, 2.0 * velocity_error(&unit), "residuals");
    within(forces, 2.0 * force_error(&unit), "residuals");
}
