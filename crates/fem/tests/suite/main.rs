//! Tests of the crate through its public interface, in one binary to save link time.

mod coupled_multigrid;
mod errors;
mod estimate;
mod exact;
mod examples;
mod hostile;
mod properties;
mod sphere;
mod support;
mod symmetry;
mod threads;
mod weak_forms;
