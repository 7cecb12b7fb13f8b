//! The tests of this crate in one binary.

mod deformation;
mod examples;
mod flow;
mod generalised_newtonian;
mod hostile;
mod inertial;
mod iterations;
mod problem;
mod squirmers;
mod support;
