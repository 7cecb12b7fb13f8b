//! The mesh of three spheres with about 280 000 dofs. PETSc and MUMPS were measured on a
//! mesh of Gmsh with 283 000 dofs.
//!
//! Run one test at a time with `--ignored --nocapture`.

use std::time::Instant;

use super::support::{body_forces, chained, three_spheres, tolerance, true_residual, with_border};
use linalg::{
    BlockTriangular, DirectParams, Multigrid, MultigridParams, SaddleLdlt, Schwarz, SchwarzParams,
    fgmres,
};

/// PETSc's additive Schwarz (restricted, overlap 1, LU) takes 75 iterations without
/// multipliers and 265 with them.
#[test]
#[ignore = "slow: 2 min, 3 GB"]
fn schwarz_on_three_spheres() {
    let stokes = three_spheres(0.3, 0.2);
    let plain = &stokes.system;
    let constrained = with_border(&stokes, chained(plain.velocity_block().corner()), None);
    for (system, petsc) in [(plain, 75), (&constrained.expect("a sound system"), 265)] {
        let b = body_forces(system);
        let start = Instant::now();
        let mut pre = Schwarz::new(system, &SchwarzParams::default()).expect("set-up");
        let (setup, bytes) = (start.elapsed(), pre.bytes());
        let mut x = vec![0.0; b.len()];
        let report = fgmres(system, &mut pre, &b, &mut x, &tolerance(1e-6)).expect("convergence");
        let (all, iterations) = (start.elapsed(), report.iterations);
        println!("{iterations} iterations, set-up {setup:.1?}, in all {all:.1?}, {bytes} bytes");
        assert!(true_residual(system, &b, &x) <= 1e-6 && iterations < petsc / 2);
    }
}

/// The reference is MUMPS on the mesh of Gmsh: 142 s and 10.5 GB on one rank, 83 s and 13.2 GB on
/// two. Half the entries (symmetric factors) of half the size (single precision) are a quarter of
/// that; the fill of two meshes with as many dofs differs by less than a tenth.
#[test]
#[ignore = "slow: 1 min, 3 GB"]
fn direct_on_three_spheres() {
    let stokes = three_spheres(0.3, 0.2);
    let b = body_forces(&stokes.system);
    let mut x = vec![0.0; b.len()];
    let start = Instant::now();
    let mut direct = SaddleLdlt::factor(&stokes.system, &DirectParams::default()).expect("factors");
    let setup = start.elapsed();
    let report = direct.solve(&b, &mut x).expect("refinement");
    let (bytes, all) = (direct.bytes(), start.elapsed());
    println!("set-up {setup:.1?}, in all {all:.1?}, {bytes} bytes, {report:?}");
    assert!(true_residual(&stokes.system, &b, &x) <= 1e-12 && bytes < 2_888_000_000);
}

/// The scalar stiffness matrix is factorised once for all three components, and the pressure
/// iterated.
#[test]
#[ignore = "slow: 10 s"]
fn factorised_velocities_on_three_spheres() {
    let stokes = three_spheres(0.3, 0.2);
    let system = &stokes.system;
    let b = body_forces(system);
    let start = Instant::now();
    let velocity = Multigrid::new(system.velocity_block(), &MultigridParams::direct());
    let mut pre = BlockTriangular::new(system, velocity.expect("factors")).expect("set-up");
    let setup = start.elapsed();
    let mut x = vec![0.0; b.len()];
    let report = fgmres(system, &mut pre, &b, &mut x, &tolerance(1e-12)).expect("convergence");
    let (all, iterations) = (start.elapsed(), report.iterations);
    println!("set-up {setup:.1?}, in all {all:.1?}, {iterations} iterations");
    assert!(true_residual(system, &b, &x) <= 1e-12 && iterations <= 40);
}
