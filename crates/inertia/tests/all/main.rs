//! The tests of this crate in one binary.

mod added_mass;
mod examples;
mod impedance;
mod laws;
mod moving;
mod referee;
mod start_up;
mod steady;
mod support;
