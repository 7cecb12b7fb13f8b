//! The tests of this crate in one binary.

mod examples;
mod history;
mod query;
mod scenes;
mod tabulated;
