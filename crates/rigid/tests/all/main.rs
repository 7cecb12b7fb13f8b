//! The tests of this crate in one binary.

mod articulation;
mod examples;
mod rates;
mod support;
mod symmetry;
mod walls;
