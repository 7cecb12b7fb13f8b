//! Project tasks: `cargo xtask ci`, `cargo xtask validate`.
#![forbid(unsafe_code)]

mod ci;
mod licences;
mod validate;

use std::path::PathBuf;

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
    /// Exact values against computed ones: prints a table and fails if a row is outside its tolerance.
    Validate {
        /// Coarser meshes and fewer rows: under two minutes on two cores.
        #[arg(long)]
        quick: bool,
        /// Folder for `validation.md` and `validation.csv`.
        #[arg(long, default_value = "validation")]
        out: PathBuf,
    },
}

fn main() -> Result<()> {
    match Arguments::parse().task {
        Task::Ci => ci::run(),
        Task::Licences => licences::run(),
        Task::Validate { quick, out } => {
            let effort = if quick {
                validate::Effort::Quick
            } else {
                validate::Effort::Full
            };
            validate::run(effort, &out)
        }
    }
}
