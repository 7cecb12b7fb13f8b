//! Right-hand sides and residuals.

use linalg::{KrylovParams, LinearOperator};

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
