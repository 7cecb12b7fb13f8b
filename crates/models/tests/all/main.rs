//! The tests of this crate in one binary.

mod bars;
mod examples;
mod history;
mod mesh_files;
mod query;
mod remeshed_files;
mod scenes;
mod table_errors;
mod tabulated;
mod units;
