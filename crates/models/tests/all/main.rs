//! The tests of this crate in one binary.

mod examples;
mod history;
mod mesh_files;
mod query;
mod scenes;
mod tabulated;
