//! Error estimates: comparison with true errors, exactly represented flows, invariants.
//!
//! True errors are known for a sphere in a concentric ball.

use std::f64::consts::PI;

use crate::support::meshes::{BODY, curved_shell, random_affine};
use crate::support::stokes::{Flow, solve, solve_rigid};
use crate::support::{dot, noise_vector};
use fem::{FemError, Surplus, SurplusSpace, consistent_load, momentum_residual};
use mesh::{TetMesh, Vec3};

/// Radius of the ball around the unit sphere.
const OUTER: f64 = 3.0;

fn surpluses<const N: usize>(mesh: &TetMesh, flows: [&Flow; N]) -> [Surplus; N] {
    let space = SurplusSpace::new(mesh).unwrap();
    flows.map(|f| space.surplus(mesh, &f.velocity, &f.pressure).unwrap())
}

/// Relative true error and estimate of the drag (along x) and the torque (about z) of a sphere.
fn errors(n: usize) -> [[f64; 2]; 2] {
    // Exact drag: Happel and Brenner 1983 (4-22.12). Exact torque: 8 π / (1 - l^3).
    let l = 1.0 / OUTER;
    let factor =
        (1.0 - l.powi(5)) / (1.0 - 2.25 * l + 2.5 * l.powi(3) - 2.25 * l.powi(5) + l.powi(6));
    let (drag, torque) = (6.0 * PI * factor, 8.0 * PI / (1.0 - l.powi(3)));

    let mesh = curved_shell(n, OUTER);
    let moving = solve_rigid(&mesh, BODY, Vec3::x(), Vec3::zeros());
    let rotating = solve_rigid(&mesh, BODY, Vec3::zeros(), Vec3::z());
    let load = |flow: &Flow, rotation: Vec3| {
        let (u, p) = (&flow.velocity, &flow.pressure);
        let residual = momentum_residual(&flow.stiffness, &flow.divergence, u, p).unwrap();
        consistent_load(&mesh, BODY, &residual, Vec3::zeros(), rotation).unwrap()
    };
    let force = load(&moving, Vec3::zeros()).force.x;
    let moment = load(&rotating, Vec3::z()).torque.z;
    let [moving, rotating] = surpluses(&mesh, [&moving, &rotating]);
    let estimate = |s: &Surplus| s.energy(s).unwrap();
    [
        [force / drag - 1.0, estimate(&moving) / drag],
        [moment / torque - 1.0, estimate(&rotating) / torque],
    ]
}

#[test]
fn estimates_of_drag_and_torque_approximate_the_errors() {
    for n in [3, 4] {
        for (what, [error, estimate]) in ["drag", "torque"].into_iter().zip(errors(n)) {
            let effectivity = estimate / error;
            // All error bars of the project are required to have an effectivity of 0.7 to 1.4.
            assert!(
                (0.7..1.4).contains(&effectivity),
                "{what}, n = {n}: error {error:.3e}, estimate {estimate:.3e}"
            );
        }
    }
    // Subtracting the estimate reduces the error at least by a factor of four.
    for [error, estimate] in errors(4) {
        assert!((error - estimate).abs() < 0.25 * error);
    }
}

#[test]
fn the_surplus_of_an_exactly_represented_flow_is_zero() {
    // u = (y z + x^2, -x y, -x z) has zero divergence, and its Laplacian (2, 0, 0) is the gradient
    // of p = 2 x.
    let mesh = random_affine(2, 7);
    let velocity: Vec<Vec3> = mesh
        .points()
        .iter()
        .map(|x| Vec3::new(x.y * x.z + x.x * x.x, -x.x * x.y, -x.x * x.z))
        .collect();
    let pressure: Vec<f64> = mesh.points()[..mesh.n_vertices()]
        .iter()
        .map(|x| 2.0 * x.x)
        .collect();
    let space = SurplusSpace::new(&mesh).unwrap();
    let found = space.surplus(&mesh, &velocity, &pressure).unwrap();
    assert!(found.energy(&found).unwrap().abs() < 1e-24);
}

/// Two independent discrete flows around the sphere.
fn two_flows(mesh: &TetMesh) -> [Flow; 2] {
    [3, 5].map(|seed| {
        let mut velocity = vec![Vec3::zeros(); mesh.n_points()];
        let motion = noise_vector(seed, 6);
        for node in mesh.nodes_on(BODY) {
            let x = mesh.points()[node as usize];
            velocity[node as usize] = Vec3::from_column_slice(&motion[..3])
                + Vec3::from_column_slice(&motion[3..]).cross(&x);
        }
        let loads = vec![Vec3::zeros(); velocity.len()];
        solve(mesh, velocity, &loads)
    })
}

#[test]
fn the_estimate_is_a_symmetric_bilinear_form_and_the_sum_of_the_indicators() {
    let mesh = curved_shell(3, OUTER);
    let [a, b] = two_flows(&mesh);
    let sum = Flow {
        velocity: a
            .velocity
            .iter()
            .zip(&b.velocity)
            .map(|(a, b)| a + 2.0 * b)
            .collect(),
        pressure: a
            .pressure
            .iter()
            .zip(&b.pressure)
            .map(|(a, b)| a + 2.0 * b)
            .collect(),
        stiffness: a.stiffness.clone(),
        divergence: a.divergence.clone(),
    };
    let [sa, sb, ss] = surpluses(&mesh, [&a, &b, &sum]);
    let energy = |a: &Surplus, b: &Surplus| a.energy(b).unwrap();
    let scale = energy(&sa, &sa) + energy(&sb, &sb);
    assert_eq!(energy(&sa, &sb), energy(&sb, &sa));
    let expanded = energy(&sa, &sa) + 4.0 * energy(&sa, &sb) + 4.0 * energy(&sb, &sb);
    assert!((energy(&ss, &ss) - expanded).abs() < 1e-12 * scale);

    let space = SurplusSpace::new(&mesh).unwrap();
    let cells = space.indicators(&mesh, &sa, &sb).unwrap();
    assert_eq!(cells.len(), mesh.n_cells());
    assert!((cells.iter().sum::<f64>() - energy(&sa, &sb)).abs() < 1e-12 * scale);
}

#[test]
fn the_functional_of_a_surplus_equals_the_estimate_for_every_other_flow() {
    let mesh = curved_shell(3, OUTER);
    let [a, b] = two_flows(&mesh);
    let space = SurplusSpace::new(&mesh).unwrap();
    let [sa, sb] = surpluses(&mesh, [&a, &b]);
    let functional = space.functional(&mesh, &sa).unwrap();
    for (flow, surplus) in [(&a, &sa), (&b, &sb)] {
        let velocities = functional.velocity.iter().zip(&flow.velocity);
        let by_velocity: f64 = velocities.map(|(f, u)| f.dot(u)).sum();
        let by_functional = by_velocity + dot(&functional.pressure, &flow.pressure);
        let scale = (sa.energy(&sa).unwrap() * surplus.energy(surplus).unwrap()).sqrt();
        assert!((by_functional - sa.energy(surplus).unwrap()).abs() < 1e-10 * scale);
    }
}

#[test]
fn estimates_are_the_same_for_any_number_of_threads() {
    let mesh = curved_shell(4, OUTER);
    let flow = solve_rigid(&mesh, BODY, Vec3::x(), Vec3::z());
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let [s] = surpluses(&mesh, [&flow]);
            let energy = s.energy(&s).unwrap();
            let functional = SurplusSpace::new(&mesh).unwrap().functional(&mesh, &s);
            (s, energy, functional.unwrap())
        })
    });
    assert_eq!(one, three);
}

#[test]
fn arrays_and_surpluses_of_another_mesh_are_errors() {
    let (mesh, other) = (curved_shell(2, OUTER), curved_shell(3, OUTER));
    let flow = solve_rigid(&mesh, BODY, Vec3::x(), Vec3::zeros());
    let space = SurplusSpace::new(&mesh).unwrap();
    let velocity = vec![Vec3::zeros(); other.n_points()];
    let pressure = vec![0.0; other.n_vertices()];
    assert!(matches!(
        space.surplus(&other, &velocity, &pressure),
        Err(FemError::OtherMesh { .. })
    ));
    let mut with_nan = flow.velocity.clone();
    with_nan[1].z = f64::NAN;
    assert!(matches!(
        space.surplus(&mesh, &with_nan, &flow.pressure),
        Err(FemError::NotFinite { index: 1, .. })
    ));
    let [surplus] = surpluses(&mesh, [&flow]);
    let zero = SurplusSpace::new(&other)
        .unwrap()
        .surplus(&other, &velocity, &pressure)
        .unwrap();
    assert!(matches!(
        surplus.energy(&zero),
        Err(FemError::Length { .. })
    ));
}
