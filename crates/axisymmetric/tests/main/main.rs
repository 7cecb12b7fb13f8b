//! Integration tests of the crate, in one binary.

mod examples;
mod hostile;
mod inertia;
mod resistance;
mod thinning;
