//! Rigid bodies in Stokes flow on structured meshes: every solver against every other.

mod support;

use linalg::*;
use support::*;

/// Forces and torques on the bodies, nothing else.
fn body_forces(system: &SaddleSystem) -> Vec<f64> {
    let mut b = vec![0.0; system.rows()];
    for (c, v) in b[system.border_range()].iter_mut().enumerate() {
        *v = 1.0 + (c as f64 * 0.7).sin();
    }
    b
}

fn block_iterations(stokes: &Stokes, rel_tol: f64) -> usize {
    let mut pre =
        BlockTriangular::with_transfer(&stokes.system, &stokes.transfer).expect("a preconditioner");
    let b = body_forces(&stokes.system);
    let mut x = vec![0.0; b.len()];
    let params = KrylovParams {
        rel_tol,
        ..KrylovParams::default()
    };
    let start = std::time::Instant::now();
    let report = fgmres(&stokes.system, &mut pre, &b, &mut x, &params).expect("convergence");
    println!("{}", pre.velocity());
    println!(
        "dofs {} its {} res {:e} in {:?}",
        b.len(),
        report.iterations,
        report.true_rel_residual,
        start.elapsed()
    );
    report.iterations
}

#[test]
fn iterations_stay_flat() {
    for k in [2, 4, 6, 8] {
        block_iterations(&one_body(k), 1e-8);
    }
    for k in [1, 2] {
        block_iterations(&two_bodies(k), 1e-8);
    }
}
