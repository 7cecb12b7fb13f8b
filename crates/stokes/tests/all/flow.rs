//! Flow with prescribed velocity on the whole boundary.

use mesh::{LinearTets, TetMesh};
use nalgebra::{Matrix3, Vector3};
use stokes::{StokesError, solve_stokes};

/// A cube with vertices that are not on a lattice.
fn irregular_cube() -> TetMesh {
    let mut tets = LinearTets::cube(3);
    let shear = Matrix3::new(1.0, 0.3, 0.0, 0.0, 0.8, 0.2, 0.1, 0.0, 1.2);
    for x in &mut tets.points {
        *x = shear * *x + 0.05 * Vector3::new(x.y * x.z, x.x * x.x, x.x * x.y);
    }
    TetMesh::straight(tets).unwrap()
}

#[test]
fn quadratic_velocity_and_linear_pressure_are_exact() {
    let velocity = |x: Vector3<f64>| {
        Vector3::new(
            x.y * x.y + x.x * x.z,
            x.z * x.z - 3.0 * x.x,
            x.x * x.x - 0.5 * x.z * x.z,
        )
    };
    let pressure = |x: Vector3<f64>| x.x + 2.0 * x.y - 3.0 * x.z;
    // f = -Δu + ∇p
    let force = |_| Vector3::new(-2.0 + 1.0, -2.0 + 2.0, -2.0 + 1.0 - 3.0);
    let mesh = irregular_cube();
    let flow = solve_stokes(&mesh, &velocity, Some(&force), 1e-12).unwrap();
    for (x, u) in mesh.points().iter().zip(&flow.velocity) {
        assert!((u - velocity(*x)).norm() < 1e-8, "{}", u - velocity(*x));
    }
    let exact: Vec<f64> = mesh.points()[..mesh.n_vertices()]
        .iter()
        .map(|&x| pressure(x))
        .collect();
    let mean = fem::mean_pressure(&mesh, &exact).unwrap();
    for (exact, p) in exact.iter().zip(&flow.pressure) {
        assert!((p - (exact - mean)).abs() < 1e-8, "{p} {}", exact - mean);
    }
    assert!(flow.report.true_rel_residual <= 1e-12);
}

#[test]
fn a_boundary_velocity_with_a_net_flux_is_refused() {
    let mesh = irregular_cube();
    let error = solve_stokes(&mesh, &|x| x, None, 1e-8).unwrap_err();
    let StokesError::NetFlux { flux, relative } = &error else {
        panic!("{error}");
    };
    // ∮ x · n = 3 |Ω|
    let volume = mesh.volume();
    assert!((flux - 3.0 * volume).abs() < 1e-10);
    // A part of the sum of the sizes.
    assert!((0.1..=1.0).contains(relative), "{relative}");
    assert!(error.to_string().contains("without net flux"), "{error}");
}
