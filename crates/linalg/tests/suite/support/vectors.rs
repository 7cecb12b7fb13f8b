//! Right-hand sides and residuals.

use linalg::{
    DirectParams, KrylovParams, LinalgError, LinearOperator, Preconditioner, SaddleLdlt,
    SaddleSystem, SolveReport,
};

/// A Krylov method.
pub type Method = fn(
    &dyn LinearOperator,
    &mut dyn Preconditioner,
    &[f64],
    &mut [f64],
    &KrylovParams,
) -> Result<SolveReport, LinalgError>;

/// Deterministic numbers in [-1, 1].
pub fn noise(n: usize) -> Vec<f64> {
    (0..n).map(|i| (i as f64 * 12.9898).sin()).collect()
}

pub fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(a, b)| a * b).sum()
}

pub fn relative_difference(x: &[f64], y: &[f64]) -> f64 {
    let difference: Vec<f64> = x.iter().zip(y).map(|(a, b)| a - b).collect();
    (dot(&difference, &difference) / dot(y, y)).sqrt()
}

pub fn true_residual(operator: &dyn LinearOperator, b: &[f64], x: &[f64]) -> f64 {
    let mut ax = vec![0.0; b.len()];
    operator.apply(x, &mut ax);
    relative_difference(&ax, b)
}

pub fn tolerance(rel_tol: f64) -> KrylovParams {
    KrylovParams::default().with_rel_tol(rel_tol)
}

/// The solution of the direct solver with its default parameters.
pub fn direct_solution(system: &SaddleSystem, b: &[f64]) -> Vec<f64> {
    let mut x = vec![0.0; b.len()];
    let mut direct = SaddleLdlt::factor(system, &DirectParams::default()).expect("factors");
    direct.solve(b, &mut x).expect("refinement");
    x
}

/// The velocities and the border, of which each solver has the same, but not the pressure.
pub fn assert_velocities_agree(system: &SaddleSystem, x: &[f64], exact: &[f64], bound: f64) {
    let velocities = 0..system.pressure_range().start;
    let difference = relative_difference(&x[velocities.clone()], &exact[velocities]);
    assert!(difference < bound, "{difference:e}");
}

/// Chunks and orders of summation do not depend on the number of threads.
pub fn assert_same_on_one_and_two_threads<T: PartialEq + Send>(solve: impl Fn() -> T + Sync) {
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool").install(&solve)
    };
    assert!(on(1) == on(2));
}
