//! Balance of force, torque and power.

use nalgebra::Vector3;

use testkit::{SceneText, forces, start, within};

use crate::scenes::{COARSE_SETTINGS, bent, rhs_bound, solve_with_flow};

#[test]
fn a_free_swimmer_exerts_no_force_and_no_torque() {
    let scene = bent(&[]);
    let instant = start(&scene);
    // The sums are the residuals of the six rows of the rigid motion of the swimmer, about its
    // first sphere.
    let tolerance = instant.solver.true_relative_residual * rhs_bound(&instant);
    let root = scene.bodies()[0].position;
    let pairs = scene.bodies().iter().zip(&instant.bodies);
    let torque = pairs.map(|(body, b)| b.torque + (body.position - root).cross(&b.force));
    within(
        forces(&instant).0.norm(),
        tolerance,
        "the residual of the solver",
    );
    within(
        torque.sum::<Vector3<f64>>().norm(),
        tolerance,
        "the residual of the solver",
    );
    // The forces themselves are of order one.
    assert!(instant.bodies.iter().all(|b| b.force.norm() > 1.0));
}

#[test]
fn forces_of_driven_bodies_are_the_applied_loads() {
    let keys = "radius = 1, force = [1, -2, 0.5], torque = [0.25, 1, -1]";
    let text = SceneText::new()
        .shape("s", keys, [1, 2, -1])
        .ball(9.0)
        .set(&COARSE_SETTINGS);
    let instant = start(&text.scene());
    // Six rows of the system have the load as right-hand side.
    let tolerance = instant.solver.true_relative_residual * (5.25_f64 + 2.0625).sqrt();
    let (tolerance, body) = (tolerance.max(1e-13), &instant.bodies[0]);
    let why = "the residual, or rounding of sums over the sphere's nodes";
    within(
        (body.force - Vector3::new(1.0, -2.0, 0.5)).norm(),
        tolerance,
        why,
    );
    within(
        (body.torque - Vector3::new(0.25, 1.0, -1.0)).norm(),
        tolerance,
        why,
    );
}

#[test]
fn the_power_of_the_bodies_is_the_energy_of_the_flow() {
    // Straight cells: every integral below is exact.
    // The energy is that of the discrete solution, without corrections.
    let scene = bent(&["fem.geometry=straight", "fem.estimates=off"]);
    let (instant, flow) = solve_with_flow(&scene);
    let power: f64 = instant
        .bodies
        .iter()
        .map(|b| b.force.dot(&b.velocity) + b.torque.dot(&b.angular_velocity))
        .sum();
    let zero = |_| (Vector3::zeros(), nalgebra::Matrix3::zeros());
    let gradient = fem::field_error(&flow.mesh, &flow.velocity, zero)
        .unwrap()
        .h1_seminorm;
    let spin: f64 = scene
        .bodies()
        .iter()
        .zip(&instant.bodies)
        .map(|(body, b)| {
            let tag = flow.mesh.tag(&body.name).unwrap();
            let volume = fem::surface_measures(&flow.mesh, tag).unwrap().volume;
            2.0 * volume * b.angular_velocity.norm_squared()
        })
        .sum();
    // They differ by p . B u, the residual of incompressibility, and by the residual of momentum
    // times u.
    let pressure: f64 = flow.pressure.iter().map(|p| p * p).sum();
    let velocity: f64 = flow.velocity.iter().map(|u| u.norm_squared()).sum();
    let tolerance = instant.solver.true_relative_residual
        * rhs_bound(&instant)
        * (pressure.sqrt() + velocity.sqrt());
    let energy = gradient * gradient + spin;
    within(power - energy, tolerance, "the residuals of both equations");

    // 2 D:D is that energy plus the square of the divergence, which vanishes only under refinement.
    let dissipation = fem::dissipation(&flow.mesh, &flow.velocity).unwrap();
    assert!(dissipation >= power - tolerance);
}

#[test]
fn the_excess_of_dissipation_over_power_decreases_under_refinement() {
    let excess = [0.6, 0.3].map(|size| {
        let text = SceneText::new().shape("s", "radius = 1, force = [1, 0, 0]", [0; 3]);
        let text = text.ball(4.0).elements(size).with("fem.rtol", "1e-10");
        let (instant, flow) = solve_with_flow(&text.scene());
        let power = instant.bodies[0].velocity.x;
        fem::dissipation(&flow.mesh, &flow.velocity).unwrap() / power - 1.0
    });
    // The square of a second-order quantity; far from the body the elements are refined less.
    assert!(excess[1] > 0.0 && excess[0] / excess[1] > 4.0, "{excess:?}");
    within(excess[0], 0.05, "elements of 0.6 radii");
}
