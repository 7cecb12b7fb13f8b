//! A saddle-point problem by flexible GMRES with a block-triangular preconditioner.
//!
//! Stokes flow in a closed cube, driven by a force in its lower half. Velocities are trilinear on a
//! grid of cells, pressures constant on blocks of `2^3` cells, a stable pair. The stiffness matrix
//! is the seven-point one.

use std::error::Error;

use linalg::sprs::TriMatI;
use linalg::{
    BlockTriangular, Bordered, Csr, Csr3, DirectParams, KrylovParams, Multigrid, MultigridParams,
    SaddleLdlt, SaddleSystem, fgmres,
};

/// Blocks in each direction.
const BLOCKS: usize = 6;
/// Inner grid points in each direction: two cells per block.
const POINTS: usize = 2 * BLOCKS - 1;

/// Assembles the system, solves it and compares the velocities with those of the direct solver.
pub fn main() -> Result<(), Box<dyn Error>> {
    let (nodes, pressures) = (POINTS.pow(3), BLOCKS.pow(3));
    let h = 1.0 / (2 * BLOCKS) as f64;
    let node = |p: [usize; 3]| (p[0] * POINTS + p[1]) * POINTS + p[2];

    let mut stiffness = TriMatI::<f64, u32>::new((nodes, nodes));
    for i in 0..nodes {
        stiffness.add_triplet(i, i, 6.0 * h);
        for stride in [1, POINTS, POINTS * POINTS] {
            if i / stride % POINTS + 1 < POINTS {
                stiffness.add_triplet(i, i + stride, -h);
                stiffness.add_triplet(i + stride, i, -h);
            }
        }
    }

    // `(B u)_q = -∫ div u` over block q: fluxes through its faces by the trapezoidal rule
    let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for q in 0..pressures {
        let block = [q / (BLOCKS * BLOCKS), q / BLOCKS % BLOCKS, q % BLOCKS];
        for corner in 0..27 {
            let offset = [corner / 9, corner / 3 % 3, corner % 3];
            let grid = [0, 1, 2].map(|d| 2 * block[d] + offset[d]);
            if grid.iter().any(|&g| g == 0 || g == 2 * BLOCKS) {
                continue; // no slip on the walls
            }
            let weight = offset.map(|o| if o == 1 { h } else { 0.5 * h });
            let outward = offset.map(|o| o as f64 - 1.0);
            let flux = |d: usize| -outward[d] * weight[(d + 1) % 3] * weight[(d + 2) % 3];
            columns.push(node(grid.map(|g| g - 1)) as u32);
            values.push([flux(0), flux(1), flux(2)]);
        }
        starts.push(columns.len());
    }
    let divergence = Csr3::new((pressures, nodes), starts, columns, values);

    // the mass matrix of the pressure over the viscosity 1 approximates the Schur complement
    let mass: Csr = Csr::eye(pressures).map(|one| one * (2.0 * h).powi(3));
    let system = SaddleSystem::new(
        Bordered::scalar(stiffness.to_csr())?,
        divergence,
        Csr::zero((pressures, 0)),
        None,
        mass,
    )?;
    let multigrid = Multigrid::new(system.velocity_block(), &MultigridParams::default())?;
    let mut preconditioner = BlockTriangular::new(&system, multigrid)?;

    // a force in direction x on the lower half
    let mut rhs = vec![0.0; system.pressure_range().end];
    for i in (0..nodes).filter(|i| i % POINTS < BLOCKS) {
        rhs[3 * i] = h.powi(3);
    }
    let mut x = vec![0.0; rhs.len()];
    let params = KrylovParams::default().with_rel_tol(1e-10);
    let report = fgmres(&system, &mut preconditioner, &rhs, &mut x, &params)?;
    println!("{} dofs, {} iterations", rhs.len(), report.iterations);
    assert!(report.iterations <= 60);

    // the direct solver finds the same velocities
    let mut exact = vec![0.0; rhs.len()];
    SaddleLdlt::factor(&system, &DirectParams::default())?.solve(&rhs, &mut exact)?;
    let largest =
        |values: &mut dyn Iterator<Item = f64>| values.fold(0.0_f64, |m, v| m.max(v.abs()));
    let velocity = system.velocity_range();
    let difference = largest(&mut velocity.clone().map(|i| x[i] - exact[i]));
    assert!(difference < 1e-7 * largest(&mut velocity.map(|i| exact[i])));
    Ok(())
}
