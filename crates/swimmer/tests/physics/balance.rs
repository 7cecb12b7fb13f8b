//! Balance of force, torque and power.

use nalgebra::Vector3;

use crate::scenes::{BALL, COARSE, bent, parse, right_side, solve, solve_with_flow};

#[test]
fn a_free_swimmer_exerts_no_force_and_no_torque() {
    let scene = bent(COARSE);
    let instant = solve(&scene);
    // The sums are the residual of the six rows of the swimmer's rigid motion, taken about its first sphere.
    let tolerance = instant.solver.true_relative_residual * right_side(&instant);
    let root = scene.bodies()[0].position;
    let force: Vector3<f64> = instant.bodies.iter().map(|b| b.force).sum();
    let torque: Vector3<f64> = scene
        .bodies()
        .iter()
        .zip(&instant.bodies)
        .map(|(body, b)| b.torque + (body.position - root).cross(&b.force))
        .sum();
    assert!(force.norm() <= tolerance, "{force:?} {tolerance:e}");
    assert!(torque.norm() <= tolerance, "{torque:?} {tolerance:e}");
    // Which says something: the forces themselves are of order one.
    assert!(instant.bodies.iter().all(|b| b.force.norm() > 1.0));
}

#[test]
fn forces_on_driven_bodies_are_those_applied() {
    let loads = "force = [1, -2, 0.5]\ntorque = [0.25, 1, -1]\n";
    let body = format!("[[bodies]]\nname = \"s\"\nradius = 1\nposition = [1, 2, -1]\n{loads}");
    let instant = solve(&parse(&format!("{BALL}{COARSE}{body}")));
    // Six rows of the system, whose right-hand side is the load.
    let tolerance = instant.solver.true_relative_residual * (5.25_f64 + 2.0625).sqrt();
    let tolerance = tolerance.max(1e-13); // rounding of sums over the sphere's nodes
    let body = &instant.bodies[0];
    assert!((body.force - Vector3::new(1.0, -2.0, 0.5)).norm() <= tolerance);
    assert!((body.torque - Vector3::new(0.25, 1.0, -1.0)).norm() <= tolerance);
}

#[test]
fn the_bodies_power_is_the_energy_of_the_flow() {
    // Straight cells: every integral below is exact.
    let scene = bent(&format!("{COARSE}fem.geometry = \"straight\"\n"));
    let (instant, flow) = solve_with_flow(&scene);
    let power: f64 = instant
        .bodies
        .iter()
        .map(|b| b.force.dot(&b.velocity) + b.torque.dot(&b.angular_velocity))
        .sum();
    let zero = |_| (Vector3::zeros(), nalgebra::Matrix3::zeros());
    let gradient = fem::velocity_error(&flow.mesh, &flow.velocity, zero)
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
    // They differ by p . B u, which is the residual of incompressibility, and by the momentum's residual times u.
    let pressure: f64 = flow.pressure.iter().map(|p| p * p).sum();
    let velocity: f64 = flow.velocity.iter().map(|u| u.norm_squared()).sum();
    let tolerance = instant.solver.true_relative_residual
        * right_side(&instant)
        * (pressure.sqrt() + velocity.sqrt());
    let energy = gradient * gradient + spin;
    assert!(
        (power - energy).abs() <= tolerance,
        "{power} {energy} {tolerance:e}"
    );

    // 2 D:D is that energy and the square of the divergence, which only vanishes with the mesh.
    let dissipation = fem::dissipation(&flow.mesh, &flow.velocity).unwrap();
    assert!(dissipation >= power - tolerance);
}

#[test]
fn dissipation_exceeds_the_power_by_the_divergence_which_falls_with_the_mesh() {
    let excess = [0.6, 0.3].map(|size| {
        let text = format!(
            "domain = {{ kind = \"ball\", radius = 4 }}\nmodel.kind = \"fem\"\nfem.surface_size = {size}\nfem.rtol = 1e-10\n\
             [[bodies]]\nname = \"s\"\nradius = 1\nposition = [0, 0, 0]\nforce = [1, 0, 0]\n"
        );
        let (instant, flow) = solve_with_flow(&parse(&text));
        let power = instant.bodies[0].velocity.x;
        fem::dissipation(&flow.mesh, &flow.velocity).unwrap() / power - 1.0
    });
    // The square of a second-order quantity where elements are refined; they are not as much far away.
    assert!(excess[1] > 0.0 && excess[0] / excess[1] > 4.0, "{excess:?}");
    assert!(excess[0] < 0.05, "{excess:?}");
}
