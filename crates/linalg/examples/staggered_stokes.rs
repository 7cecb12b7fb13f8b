//! Stokes flow on a staggered grid by flexible GMRES with a block preconditioner of one's own.
//!
//! `-Δu + ∇p = f`, `div u = 0` in the unit square with no slip on its boundary (Harlow, Welch
//! 1965): pressures in the centres of cells, velocities normal to their faces. Three blocks, one
//! for each velocity component and one for the pressure, whose Schur complement is close to the
//! identity.

use std::error::Error;

use linalg::{
    BlockForm, BlockPreconditionerBuilder, Csr, CsrOperator, ExplicitInverse, KrylovParams,
    MultigridParams, NullVectors, PreconditionerKind, ScalarMultigrid, fgmres,
};
use sprs::TriMatI;

/// Solves on three grids: the number of iterations does not grow, the error falls as `h^2`.
pub fn main() -> Result<(), Box<dyn Error>> {
    let solutions: Vec<(usize, f64)> = [32, 64, 128]
        .into_iter()
        .map(solve)
        .collect::<Result<_, _>>()?;
    // on the first grid multigrid has two levels only, of which one is solved exactly
    assert!(solutions[2].0 <= solutions[1].0 + 3, "{solutions:?}");
    for pair in solutions.windows(2) {
        // the scheme is of second order: a ratio of 4, up to terms of higher order
        let ratio = pair[0].1 / pair[1].1;
        assert!((3.6..4.4).contains(&ratio), "{solutions:?}");
    }
    Ok(())
}

/// The matrices on `n^2` cells; velocities are numbered along x first.
struct Blocks {
    /// `-h^2 Δ` for either velocity component.
    laplacians: [Csr; 2],
    /// `h^2 ∂/∂x` and `h^2 ∂/∂y` of the pressure.
    gradients: [Csr; 2],
}

/// Assembles the blocks for `n` cells in each direction.
fn blocks(n: usize) -> Blocks {
    let h = 1.0 / n as f64;
    let parts = [0, 1].map(|d| {
        // inner faces normal to direction d
        let size = if d == 0 { [n - 1, n] } else { [n, n - 1] };
        let faces = size[0] * size[1];
        let mut laplacian = TriMatI::<f64, u32>::new((faces, faces));
        let mut gradient = TriMatI::<f64, u32>::new((faces, n * n));
        for i in 0..faces {
            let place = [i % size[0], i / size[0]];
            for e in 0..2 {
                // at a wall the velocity is zero on the face itself, or half a cell away
                let wall = if e == d { 1.0 } else { 2.0 };
                let stride = if e == 0 { 1 } else { size[0] };
                let (low, high) = (place[e] == 0, place[e] + 1 == size[e]);
                for (at_wall, neighbour) in [(low, i.wrapping_sub(stride)), (high, i + stride)] {
                    if at_wall {
                        laplacian.add_triplet(i, i, wall);
                    } else {
                        laplacian.add_triplet(i, i, 1.0);
                        laplacian.add_triplet(i, neighbour, -1.0);
                    }
                }
            }
            let cell = place[0] + n * place[1];
            let next = if d == 0 { cell + 1 } else { cell + n };
            gradient.add_triplet(i, cell, -h);
            gradient.add_triplet(i, next, h);
        }
        (laplacian.to_csr(), gradient.to_csr())
    });
    let [(lx, gx), (ly, gy)] = parts;
    Blocks {
        laplacians: [lx, ly],
        gradients: [gx, gy],
    }
}

/// `[A_x 0 G_x; 0 A_y G_y; G_x^T G_y^T 0]`.
fn whole(blocks: &Blocks) -> Csr {
    let [nx, ny] = [0, 1].map(|d| blocks.laplacians[d].rows());
    let total = nx + ny + blocks.gradients[0].cols();
    let mut matrix = TriMatI::<f64, u32>::new((total, total));
    for (d, first) in [0, nx].into_iter().enumerate() {
        for (&value, (i, j)) in blocks.laplacians[d].iter() {
            matrix.add_triplet(first + i as usize, first + j as usize, value);
        }
        for (&value, (i, j)) in blocks.gradients[d].iter() {
            let (row, column) = (first + i as usize, nx + ny + j as usize);
            matrix.add_triplet(row, column, value);
            matrix.add_triplet(column, row, value);
        }
    }
    matrix.to_csr()
}

/// Forces times `h^2`, and the exact velocities at the faces.
///
/// The stream function is `g(x) g(y)` with `g = t^2 (1 - t)^2`, the pressure `x + y`.
fn manufactured(n: usize) -> (Vec<f64>, Vec<f64>) {
    let h = 1.0 / n as f64;
    let g = |t: f64| t * t * (1.0 - t) * (1.0 - t);
    let g1 = |t: f64| 2.0 * t - 6.0 * t * t + 4.0 * t * t * t;
    let g2 = |t: f64| 2.0 - 12.0 * t + 12.0 * t * t;
    let g3 = |t: f64| -12.0 + 24.0 * t;
    let (mut forces, mut velocities) = (Vec::new(), Vec::new());
    for (d, size) in [[n - 1, n], [n, n - 1]].into_iter().enumerate() {
        for i in 0..size[0] * size[1] {
            let place = [i % size[0], i / size[0]];
            // the coordinate in direction d, and the other one
            let s = (place[d] + 1) as f64 * h;
            let t = (place[1 - d] as f64 + 0.5) * h;
            let sign = if d == 0 { 1.0 } else { -1.0 };
            velocities.push(sign * g(s) * g1(t));
            let laplacian = sign * (g2(s) * g1(t) + g(s) * g3(t));
            forces.push(h * h * (1.0 - laplacian));
        }
    }
    (forces, velocities)
}

/// Number of iterations and largest error of the velocity with `n^2` cells.
fn solve(n: usize) -> Result<(usize, f64), Box<dyn Error>> {
    let matrices = blocks(n);
    let system = CsrOperator::new(whole(&matrices))?;
    let [lx, ly] = matrices.laplacians.map(CsrOperator::new);
    let [gx, gy] = matrices.gradients.map(CsrOperator::new);
    let (lx, ly, gx, gy) = (lx?, ly?, gx?, gy?);
    let (nx, velocities, total) = (
        lx.matrix().rows(),
        2 * lx.matrix().rows(),
        system.matrix().rows(),
    );

    // S = G^T (h^2 Δ)^-1 G is close to h^2 I, for the grid as for the continuous problem
    let inverse: Csr = Csr::eye(n * n).map(|one: &f64| one * (n * n) as f64);
    let definite = PreconditionerKind::PositiveDefinite;
    let schur = ExplicitInverse::new(CsrOperator::new(inverse)?, definite)?;
    let params = MultigridParams::default().with_sweeps(2);
    let mut preconditioner = BlockPreconditionerBuilder::new(total)
        .block("velocity in x", 0..nx, ScalarMultigrid::new(&lx, &params)?)
        .block(
            "velocity in y",
            nx..velocities,
            ScalarMultigrid::new(&ly, &params)?,
        )
        .schur_complement("pressure", velocities..total, schur)
        .coupling("velocity in x", "pressure", &gx)
        .coupling("velocity in y", "pressure", &gy)
        .build(BlockForm::Upper)?;

    let (mut rhs, exact) = manufactured(n);
    rhs.resize(total, 0.0);
    let mut x = vec![0.0; total];
    let constant_pressure = NullVectors::constant_on(total, velocities..total)?;
    let krylov = KrylovParams::default().with_null_vectors(constant_pressure);
    let report = fgmres(&system, &mut preconditioner, &rhs, &mut x, &krylov)?;
    let error = x
        .iter()
        .zip(&exact)
        .fold(0.0_f64, |m, (u, e)| m.max((u - e).abs()));
    println!(
        "{n}^2 cells, {} iterations, error {error:.2e}",
        report.iterations
    );
    assert!(report.iterations <= 40);
    Ok((report.iterations, error))
}
