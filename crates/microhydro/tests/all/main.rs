//! Tests of the public interface, in one binary.

mod breathing;
mod contract;
mod exact;
mod examples;
mod hostile;
mod many;
mod many_squirmers;
mod mean_flow;
mod periodic_arrays;
mod properties;
mod squirmers;
mod stresslets;
mod velocity_field;

use microhydro::Linkage;
use nalgebra::{DMatrix, DVector, Vector3};

/// A free sphere with a load.
fn free(sphere: usize, load: DVector<f64>) -> Linkage {
    Linkage {
        spheres: vec![sphere],
        basis: DMatrix::identity(6, 6),
        offset: DVector::zeros(6),
        load,
        damping: DMatrix::zeros(6, 6),
    }
}

/// A sphere that is held at this velocity and angular velocity.
fn held(sphere: usize, offset: DVector<f64>) -> Linkage {
    Linkage {
        spheres: vec![sphere],
        basis: DMatrix::zeros(6, 0),
        offset,
        load: DVector::zeros(0),
        damping: DMatrix::zeros(0, 0),
    }
}

/// The sum of the forces among forces and torques on spheres.
fn total_force(loads: &DVector<f64>) -> Vector3<f64> {
    let loads = loads.as_slice().chunks_exact(6);
    loads
        .map(|load| Vector3::from_column_slice(&load[..3]))
        .sum()
}

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
