//! A scalar Poisson problem by conjugate gradients with algebraic multigrid.
//!
//! `-Δu = 1` in the unit cube with `u = 0` on its boundary, by the seven-point stencil.

use std::error::Error;

use linalg::{CsrOperator, KrylovParams, MultigridParams, ScalarMultigrid, cg};
use sprs::TriMatI;

/// Inner grid points in each direction.
const POINTS: usize = 39;

/// Assembles the system, solves it and checks the value in the centre.
pub fn main() -> Result<(), Box<dyn Error>> {
    let n = POINTS.pow(3);
    let mut matrix = TriMatI::<f64, u32>::new((n, n));
    for i in 0..n {
        matrix.add_triplet(i, i, 6.0);
        for stride in [1, POINTS, POINTS * POINTS] {
            // the neighbour in the positive direction, unless that is the boundary
            if i / stride % POINTS + 1 < POINTS {
                matrix.add_triplet(i, i + stride, -1.0);
                matrix.add_triplet(i + stride, i, -1.0);
            }
        }
    }
    let laplacian = CsrOperator::new(matrix.to_csr())?;
    let mut multigrid = ScalarMultigrid::new(&laplacian, &MultigridParams::default())?;

    let h = 1.0 / (POINTS + 1) as f64;
    let rhs = vec![h * h; n];
    let mut u = vec![0.0; n];
    let params = KrylovParams::default().with_rel_tol(1e-10);
    let report = cg(&laplacian, &mut multigrid, &rhs, &mut u, &params)?;

    let centre = u[n / 2];
    println!(
        "{n} dofs, {} iterations, u(centre) = {centre:.6}",
        report.iterations
    );
    // the Fourier series of the exact solution gives 0.0562128; the stencil is of second order
    assert!((centre - 0.056_212_8).abs() < 0.1 * h * h);
    assert!(report.iterations <= 20);
    Ok(())
}
