//! A nonsymmetric problem in two dimensions by flexible GMRES.
//!
//! `-Δu + w · ∇u = f` in the unit square with `u = 0` on its boundary and the rotating wind
//! `w = 20 (y - 1/2, 1/2 - x)`, by central differences. The preconditioner is multigrid for the
//! symmetric part of the matrix.

use std::error::Error;

use linalg::{CsrOperator, KrylovParams, MultigridParams, ScalarMultigrid, fgmres};
use sprs::TriMatI;

/// Solves on three grids: the number of iterations does not grow, and the solution is exact.
pub fn main() -> Result<(), Box<dyn Error>> {
    let iterations: Vec<usize> = [32, 64, 128]
        .into_iter()
        .map(solve)
        .collect::<Result<_, _>>()?;
    assert!(iterations[2] <= iterations[0] + 2, "{iterations:?}");
    assert!(iterations[2] <= 30, "{iterations:?}");
    Ok(())
}

/// Number of iterations with `cells` cells in each direction.
fn solve(cells: usize) -> Result<usize, Box<dyn Error>> {
    let (m, h) = (cells - 1, 1.0 / cells as f64);
    let wind = |x: f64, y: f64| [20.0 * (y - 0.5), 20.0 * (0.5 - x)];
    // second and first central differences are exact for quadratic polynomials
    let (shape, slope) = (|t: f64| t * (1.0 - t), |t: f64| 1.0 - 2.0 * t);
    let mut matrix = TriMatI::<f64, u32>::new((m * m, m * m));
    let (mut exact, mut rhs) = (Vec::new(), Vec::new());
    for i in 0..m * m {
        let place = [i % m, i / m];
        let [x, y] = place.map(|p| (p + 1) as f64 * h);
        let w = wind(x, y);
        matrix.add_triplet(i, i, 4.0);
        for (d, stride) in [1, m].into_iter().enumerate() {
            if place[d] + 1 < m {
                matrix.add_triplet(i, i + stride, -1.0 + 0.5 * h * w[d]);
            }
            if place[d] > 0 {
                matrix.add_triplet(i, i - stride, -1.0 - 0.5 * h * w[d]);
            }
        }
        exact.push(shape(x) * shape(y));
        let convection = w[0] * slope(x) * shape(y) + w[1] * shape(x) * slope(y);
        rhs.push(h * h * (2.0 * shape(x) + 2.0 * shape(y) + convection));
    }
    let operator = CsrOperator::new(matrix.to_csr())?;
    let params = MultigridParams::default();
    let mut multigrid = ScalarMultigrid::from_symmetric_part(&operator, &params)?;
    let mut u = vec![0.0; rhs.len()];
    let krylov = KrylovParams::default().with_rel_tol(1e-10);
    let report = fgmres(&operator, &mut multigrid, &rhs, &mut u, &krylov)?;
    let error = u
        .iter()
        .zip(&exact)
        .fold(0.0_f64, |m, (u, e)| m.max((u - e).abs()));
    println!(
        "{cells}^2 cells, {} iterations, error {error:.1e}",
        report.iterations
    );
    assert!(error < 1e-7);
    Ok(report.iterations)
}
