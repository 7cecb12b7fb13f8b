//! Error estimates: comparison with true errors, exactly represented flows, invariants.
//!
//! True errors are known for a sphere in a concentric ball.

use std::f64::consts::PI;

use crate::support::meshes::{BODY, curved_shell, random_affine};
use crate::support::stokes::{Flow, solve, solve_rigid};
use crate::support::{dot, noise_field, noise_vector};
use fem::{
    CubicExtension, CubicProduct, FemError, Surplus, SurplusSpace, TaylorHood, consistent_load,
    continuity_residual, momentum_residual,
};
use mesh::{TET_EDGES, TetMesh, Vec3};

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

/// Dofs of the extension for a flow of cubic velocities and quadratic pressures.
fn extension_of(
    mesh: &TetMesh,
    bubbles: usize,
    velocity: impl Fn(&Vec3) -> Vec3,
    pressure: impl Fn(&Vec3) -> f64,
) -> Vec<f64> {
    let n = mesh.n_vertices();
    let edges = mesh.n_points() - n;
    let mut extension = vec![0.0; bubbles + edges];
    let at = |nodes: &[u32], l: &[f64]| -> Vec3 {
        let terms = nodes.iter().zip(l);
        terms.map(|(&v, &l)| mesh.points()[v as usize] * l).sum()
    };
    let mut faces = std::collections::BTreeSet::new();
    for cell in mesh.cells() {
        for (k, [a, b]) in TET_EDGES.into_iter().enumerate() {
            let (low, high) = (cell[a].min(cell[b]), cell[a].max(cell[b]));
            let edge = cell[4 + k] as usize - n;
            // l_a l_b (l_a - l_b) is 3 / 32 where l_a = 3 / 4, and quadratic interpolation there
            // has the weights 3 / 8, -1 / 8 and 3 / 4.
            let value = |l: f64| velocity(&at(&[low, high], &[l, 1.0 - l]));
            let interpolated = 0.375 * value(1.0) - 0.125 * value(0.0) + 0.75 * value(0.5);
            let coefficient = (value(0.75) - interpolated) * 32.0 / 3.0;
            extension[3 * edge..3 * edge + 3].copy_from_slice(coefficient.as_slice());
            let value = |l: f64| pressure(&at(&[low, high], &[l, 1.0 - l]));
            let linear = 0.5 * (value(0.0) + value(1.0));
            extension[bubbles + edge] = 4.0 * (value(0.5) - linear);
        }
        for opposite in 0..4 {
            let mut face: Vec<u32> = (0..4).filter(|&v| v != opposite).map(|v| cell[v]).collect();
            face.sort_unstable();
            faces.insert(face);
        }
    }
    // Faces are numbered after the edges, by their sorted vertices.
    for (number, face) in faces.iter().enumerate() {
        let value = |l: [f64; 3]| velocity(&at(face, &l));
        let third = 1.0 / 3.0;
        // Quadratic interpolation at the centroid; the bubbles of edges are zero there, and that of
        // the face is 1 / 27.
        let corners = value([1.0, 0.0, 0.0]) + value([0.0, 1.0, 0.0]) + value([0.0, 0.0, 1.0]);
        let middles = value([0.5, 0.5, 0.0]) + value([0.5, 0.0, 0.5]) + value([0.0, 0.5, 0.5]);
        let interpolated = -third * third * corners + 4.0 * third * third * middles;
        let coefficient = 27.0 * (value([third; 3]) - interpolated);
        let first = 3 * (edges + number);
        extension[first..first + 3].copy_from_slice(coefficient.as_slice());
    }
    extension
}

#[test]
fn a_flow_of_cubic_velocities_and_quadratic_pressures_satisfies_the_extended_equations() {
    // From the stream function x^3 y + x y^3, whose Laplacian 12 x y is harmonic.
    let velocity = |x: &Vec3| {
        Vec3::new(
            x.x.powi(3) + 3.0 * x.x * x.y * x.y,
            -3.0 * x.x * x.x * x.y - x.y.powi(3),
            0.0,
        )
    };
    let pressure = |x: &Vec3| 6.0 * (x.x * x.x - x.y * x.y);
    let mesh = random_affine(2, 7);
    let space = SurplusSpace::new(&mesh).unwrap();
    let cubic = CubicExtension::new(&space, &mesh).unwrap();
    let extension = extension_of(&mesh, cubic.first_pressure(), velocity, pressure);
    assert_eq!(extension.len(), cubic.len());
    let u: Vec<Vec3> = mesh.points().iter().map(velocity).collect();
    let vertices = &mesh.points()[..mesh.n_vertices()];
    let p: Vec<f64> = vertices.iter().map(pressure).collect();
    let product = cubic.product(&u, &p, &extension).unwrap();
    let size = velocity(&Vec3::repeat(3.0)).norm();
    let largest = product
        .extension
        .iter()
        .fold(0.0_f64, |m, r| m.max(r.abs()));
    assert!(largest < 1e-10 * size, "{largest:e}");
    // With the block of the Taylor-Hood elements the other rows vanish in the interior.
    let space = TaylorHood::new(&mesh).unwrap();
    let (k, b) = (
        space.stiffness(&mesh).unwrap(),
        space.divergence(&mesh).unwrap(),
    );
    let momentum = momentum_residual(&k, &b, &u, &p).unwrap();
    let mut is_inside = vec![true; mesh.n_points()];
    for facet in mesh.facets() {
        facet
            .nodes
            .iter()
            .for_each(|&node| is_inside[node as usize] = false);
    }
    for node in (0..mesh.n_points()).filter(|&node| is_inside[node]) {
        let residual = momentum[node] + product.velocity[node];
        assert!(residual.norm() < 1e-10 * size, "{residual}");
    }
    let continuity = continuity_residual(&b, &u).unwrap();
    for (own, cubic) in continuity.iter().zip(&product.pressure) {
        assert!((own + cubic).abs() < 1e-10 * size);
    }
}

#[test]
fn the_extended_matrix_is_symmetric_and_its_parts_are_those_of_the_whole_product() {
    // Affine and curved cells.
    let mesh = curved_shell(3, OUTER);
    let space = SurplusSpace::new(&mesh).unwrap();
    let cubic = CubicExtension::new(&space, &mesh).unwrap();
    let random = |seed: u64| {
        let mut extension = noise_vector(seed + 2, cubic.len());
        // Bubbles on the boundary are no dofs.
        let free = cubic.product(
            &vec![Vec3::zeros(); mesh.n_points()],
            &vec![0.0; mesh.n_vertices()],
            &extension,
        );
        for (value, row) in extension.iter_mut().zip(free.unwrap().extension) {
            *value = if row == 0.0 { 0.0 } else { *value };
        }
        (
            noise_field(seed, mesh.n_points()),
            noise_vector(seed + 1, mesh.n_vertices()),
            extension,
        )
    };
    let (a, b) = (random(3), random(11));
    let [of_a, of_b] = [&a, &b].map(|(u, p, e)| cubic.product(u, p, e).unwrap());
    let form = |(u, p, e): &(Vec<Vec3>, Vec<f64>, Vec<f64>), of: &CubicProduct| {
        let velocities: f64 = u.iter().zip(&of.velocity).map(|(u, r)| u.dot(r)).sum();
        velocities + dot(p, &of.pressure) + dot(e, &of.extension)
    };
    let (ab, ba) = (form(&a, &of_b), form(&b, &of_a));
    let scale = form(&a, &of_a).abs() + form(&b, &of_b).abs();
    assert!((ab - ba).abs() < 1e-12 * scale, "{ab} {ba}");

    let at_rest = vec![Vec3::zeros(); mesh.n_points()];
    let whole = cubic
        .product(&at_rest, &vec![0.0; mesh.n_vertices()], &a.2)
        .unwrap();
    let coarse = cubic.coarse_rows(&a.2).unwrap();
    for (one, other) in coarse.velocity.iter().zip(&whole.velocity) {
        assert!((one - other).norm() < 1e-12 * scale);
    }
    assert_eq!(coarse.pressure, whole.pressure);
    let pressures: Vec<f64> = (0..cubic.len())
        .map(|k| {
            if k < cubic.first_pressure() {
                0.0
            } else {
                a.2[k]
            }
        })
        .collect();
    let whole = cubic
        .product(&at_rest, &vec![0.0; mesh.n_vertices()], &pressures)
        .unwrap();
    let mut rows = vec![1.0; cubic.len()];
    let (at_nodes, at_vertices) = (&at_rest, vec![0.0; mesh.n_vertices()]);
    let coarse = (cubic.product_into(at_nodes, &at_vertices, &pressures, &mut rows)).unwrap();
    assert_eq!(rows, whole.extension);
    assert_eq!(
        (coarse.velocity, coarse.pressure),
        (whole.velocity.clone(), whole.pressure.clone())
    );
    // The dofs of bubbles are not read.
    let mut gradient = pressures.clone();
    gradient[..cubic.first_pressure()].fill(7.0);
    cubic.gradient(&mut gradient).unwrap();
    let bubbles = ..cubic.first_pressure();
    assert_eq!(gradient[bubbles], whole.extension[bubbles]);
    // The diagonal is that of the product with unit vectors.
    for k in [0, cubic.first_pressure() / 2, cubic.first_pressure() - 1] {
        let mut unit = vec![0.0; cubic.len()];
        unit[k] = 1.0;
        let row = cubic
            .product(&at_rest, &vec![0.0; mesh.n_vertices()], &unit)
            .unwrap()
            .extension[k];
        let is_free = row != 0.0;
        assert!(!is_free || (row / cubic.diagonal(k) - 1.0).abs() < 1e-12);
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
            let space = SurplusSpace::new(&mesh).unwrap();
            let cubic = CubicExtension::new(&space, &mesh).unwrap();
            let extension = noise_vector(5, cubic.len());
            let product = cubic.product(&flow.velocity, &flow.pressure, &extension);
            (s, energy, product.unwrap())
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
