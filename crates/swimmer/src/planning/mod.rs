//! Decisions before a run: the model, the element sizes, tables over shapes.

mod choice;
mod sphere_model;
mod tables;
mod target;

pub use choice::{Choice, choose};
pub use tables::with_tables;
pub use target::{MissedTarget, SizeSearch, simulate_to_target};
