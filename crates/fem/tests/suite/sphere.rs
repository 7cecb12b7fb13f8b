//! Observed orders for a sphere in a concentric ball with exactly known geometry, drag and torque.
//!
//! The meshes of a family are similar: each edge of the icosahedron is divided into n, and there
//! are n layers in geometric progression, so h is proportional to 1/n.

use std::f64::consts::PI;

use crate::support::meshes::{BODY, CONTAINER, curved_shell, straight_shell};
use crate::support::stokes::solve_rigid;
use fem::{SurfaceMeasures, consistent_load, momentum_residual, stress_load, surface_measures};
use mesh::{TetMesh, Vec3};

/// Radius of the ball around the unit sphere.
const OUTER: f64 = 3.0;
/// Numbers n of the coarse and the fine mesh.
const LEVELS: [usize; 2] = [4, 6];

/// Relative errors of drag and torque of a sphere that moves along x and rotates about z.
struct Errors {
    drag: f64,
    torque: f64,
    stress_drag: f64,
    stress_torque: f64,
}

fn load_errors(mesh: &TetMesh) -> Errors {
    // Exact drag: Happel and Brenner 1983 (4-22.12). Exact torque: 8 π / (1 - l^3).
    let l = 1.0 / OUTER;
    let factor =
        (1.0 - l.powi(5)) / (1.0 - 2.25 * l + 2.5 * l.powi(3) - 2.25 * l.powi(5) + l.powi(6));
    let (drag, torque) = (6.0 * PI * factor, 8.0 * PI / (1.0 - l.powi(3)));

    let flow = solve_rigid(mesh, BODY, Vec3::x(), Vec3::z());
    let (u, p) = (&flow.velocity, &flow.pressure);
    let residual = momentum_residual(&flow.stiffness, &flow.divergence, u, p).unwrap();
    let load = consistent_load(mesh, BODY, &residual, Vec3::zeros(), Vec3::z()).unwrap();
    let stress = stress_load(mesh, BODY, u, p, Vec3::zeros()).unwrap();
    Errors {
        drag: load.force.x / drag - 1.0,
        torque: load.torque.z / torque - 1.0,
        stress_drag: stress.force.x / drag - 1.0,
        stress_torque: stress.torque.z / torque - 1.0,
    }
}

/// Observed order of convergence from the coarse to the fine level.
fn order([coarse, fine]: [f64; 2]) -> f64 {
    (coarse / fine).abs().ln() / (LEVELS[1] as f64 / LEVELS[0] as f64).ln()
}

#[test]
fn loads_on_curved_cells_are_of_fourth_order() {
    let [coarse, fine] = LEVELS.map(|n| load_errors(&curved_shell(n, OUTER)));
    // The theoretical order is 4; the bound 3.3 allows for meshes that are not yet asymptotic.
    assert!(
        order([coarse.drag, fine.drag]) > 3.3,
        "{} {}",
        coarse.drag,
        fine.drag
    );
    assert!(
        order([coarse.torque, fine.torque]) > 3.3,
        "{} {}",
        coarse.torque,
        fine.torque
    );
    // The error is an energy, so the computed resistance is too large.
    assert!(fine.drag > 0.0 && fine.drag < 1e-3);
    assert!(fine.torque > 0.0 && fine.torque < 1e-3);
    // Integrals of the stress give the same loads independently, at least of first order.
    assert!(order([coarse.stress_drag, fine.stress_drag]) > 1.0);
    assert!(fine.stress_drag.abs() < 0.01 && fine.stress_torque.abs() < 0.01);
}

#[test]
fn loads_on_straight_cells_have_the_order_of_the_geometry_error() {
    let [coarse, fine] = LEVELS.map(|n| load_errors(&straight_shell(n, OUTER)));
    // The geometry error of straight facets is of order 2; a higher order would be as wrong as a
    // lower one.
    for pair in [[coarse.drag, fine.drag], [coarse.torque, fine.torque]] {
        assert!(
            (1.2..2.5).contains(&order(pair)),
            "{pair:?}: {}",
            order(pair)
        );
    }
    assert!(
        fine.torque < 0.0,
        "the resistance of an inscribed polyhedron is smaller"
    );
}

/// Relative errors of area and volume of a surface of the given radius.
fn measure_errors(measures: SurfaceMeasures, radius: f64) -> [f64; 2] {
    let area = measures.area / (4.0 * PI * radius.powi(2)) - 1.0;
    let volume = measures.volume / (4.0 / 3.0 * PI * radius.powi(3)) - 1.0;
    [area, volume]
}

#[test]
fn area_and_volume_are_of_fourth_order_on_curved_and_second_on_straight_cells() {
    for (tag, radius) in [(BODY, 1.0), (CONTAINER, OUTER)] {
        for (family, expected) in [
            (curved_shell as fn(usize, f64) -> TetMesh, 4.0),
            (straight_shell, 2.0),
        ] {
            let [coarse, fine] = LEVELS.map(|n| {
                let measures = surface_measures(&family(n, OUTER), tag).unwrap();
                // By the symmetry of the icosahedron the centroid is at the centre.
                assert!(measures.centroid.norm() < 1e-14 * radius);
                measure_errors(measures, radius)
            });
            for k in 0..2 {
                let order = order([coarse[k], fine[k]]);
                assert!((order - expected).abs() < 0.15, "tag {tag}: order {order}");
            }
        }
    }
}
