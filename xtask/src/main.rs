//! Project tasks: `cargo xtask ci`, `cargo xtask validate`.
#![forbid(unsafe_code)]

mod ci;
mod licences;

use anyhow::Result;
use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "Project tasks")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Format check, lints, documentation, licences and tests: what CI runs.
    Ci,
    /// Licences of everything in the default dependency graph; GPL and AGPL are refused.
    Licences,
}

fn main() -> Result<()> {
    match Arguments::parse().task {
        Task::Ci => ci::run(),
        Task::Licences => licences::run(),
    }
}
