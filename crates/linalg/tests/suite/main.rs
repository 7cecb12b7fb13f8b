//! Integration tests of `linalg`, in one binary.

mod blocks;
mod claims;
mod columns;
mod constrained_dofs;
mod coupled;
mod examples;
mod failures;
mod hostile;
mod large;
mod minres;
mod null_vectors;
mod processes;
mod properties;
mod scalar;
mod schwarz;
mod stokes;
mod support;
