//! The tests of this crate in one binary.

mod examples;
mod flow;
mod iterations;
mod problem;
