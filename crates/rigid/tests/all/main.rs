//! The tests of this crate in one binary.

// every example contains its own copy of the module that assembles matrices
#![allow(clippy::duplicate_mod)]

mod articulation;
mod examples;
mod hostile;
mod joints;
mod rates;
mod support;
mod symmetry;
mod walls;
