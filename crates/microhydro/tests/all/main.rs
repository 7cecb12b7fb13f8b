//! Tests of the public interface, in one binary.

mod breathing;
mod contract;
mod exact;
mod examples;
mod hostile;
mod many;
mod mean_flow;
mod periodic_arrays;
mod properties;
mod squirmers;
mod stresslets;
mod velocity_field;

use nalgebra::DMatrix;

/// Largest difference of an entry, relative to the diagonal entries of its row and column.
fn distance(found: &DMatrix<f64>, exact: &DMatrix<f64>) -> f64 {
    let n = exact.nrows();
    let error = |i: usize, j: usize| {
        let scale = (exact[(i, i)] * exact[(j, j)]).sqrt();
        ((found[(i, j)] - exact[(i, j)]) / scale).abs()
    };
    // NaN is larger than any number
    (0..n * n)
        .map(|k| error(k / n, k % n))
        .max_by(f64::total_cmp)
        .unwrap_or(0.0)
}
