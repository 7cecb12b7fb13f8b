//! All tests of the public interface.

mod examples;
mod generate;
mod hostile;
mod symmetry;
mod triangulated;
