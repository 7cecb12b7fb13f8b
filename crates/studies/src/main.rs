//! Studies that measure the workspace: `cargo xtask validate`, `cargo xtask table1` and others.
#![forbid(unsafe_code)]

mod accuracy;
mod ale;
mod chart;
mod columns;
mod folder;
mod iterations;
mod machine;
mod models;
mod page;
mod roofline;
mod soak;
mod stability;
mod table1;
mod validate;

use std::path::PathBuf;

use anyhow::Result;
use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(name = "cargo xtask", about = "Studies that measure the workspace")]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Exact values against computed ones: prints a table and fails if a row is outside its tolerance.
    Validate {
        /// Coarser meshes and fewer rows: under two minutes on two cores.
        #[arg(long)]
        quick: bool,
        /// Folder for `validation.md`, `validation.csv`, the charts and the page `index.html`.
        #[arg(long, default_value = "validation")]
        out: PathBuf,
    },
    /// Speed against accuracy: drag, swimming speed and net displacement computed in every way there is.
    Accuracy {
        /// Two mesh sizes: a minute on two cores.
        #[arg(long)]
        quick: bool,
        /// Only this quantity: drag, pair, speed or net.
        #[arg(long)]
        only: Option<String>,
        /// Folder for `accuracy.md`, `accuracy.csv` and the charts [default: docs, or accuracy for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Mesh motions against each other: large steps, small steps, approach, closed cycles.
    Ale {
        /// A coarse mesh and two cycles: half a minute on two cores.
        #[arg(long)]
        quick: bool,
        /// Folder for `ale.md`, `ale.csv`, charts and pictures [default: docs, or ale for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Every model on every scene with an exact answer: error claimed, error made, seconds; fails where a claim does not hold.
    Models {
        /// Without finite elements: seconds.
        #[arg(long)]
        quick: bool,
        /// Folder for `models.md` and `models.csv` [default: docs, or models for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// The stability map: formulations x solvers x hardships, each right or refused with a reason.
    Stability {
        /// The part that the tests run.
        #[arg(long)]
        quick: bool,
        /// Folder for `stability.md` and `stability.csv` [default: docs, or stability for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// The paper's Table 1 measured again: formulations x solvers x sizes, about an hour at full size.
    Table1 {
        /// One small mesh: a minute on two cores.
        #[arg(long)]
        quick: bool,
        /// Only the smallest so many of the three sizes.
        #[arg(long, default_value_t = 3)]
        sizes: usize,
        /// Rounds of which the block solver's median is taken.
        #[arg(long, default_value_t = 3)]
        repeats: usize,
        /// Folder for `table1.md`, `table1.csv` and `table1.svg` [default: docs, or table1 for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Every kernel of the block solver against the bandwidth of memory, which is measured in the same run.
    Roofline {
        /// One small mesh: half a minute on two cores.
        #[arg(long)]
        quick: bool,
        /// Folder for `roofline.md` and `roofline.csv` [default: docs, or roofline for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Iterations of the block solver over sizes, containers, gaps, numbers of bodies and radius ratios, and its gain from a second thread.
    Iterations {
        /// Small meshes: two minutes on two cores.
        #[arg(long)]
        quick: bool,
        /// Folder for `iterations.md` [default: docs, or iterations for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Random valid scenes through all models for a while: balances, the same bits again, flat memory.
    Soak {
        /// How long.
        #[arg(long, default_value_t = 30.0)]
        minutes: f64,
        /// Where the random numbers begin: the same seed draws the same scenes.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// One cell of the table, in a process of its own.
    #[command(hide = true)]
    Table1Cell { overrides: Vec<String> },
}

/// A folder under the project's own documents.
const DOCS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs");

fn main() -> Result<()> {
    match Arguments::parse().task {
        Task::Validate { quick, out } => {
            let effort = if quick {
                validate::Effort::Quick
            } else {
                validate::Effort::Full
            };
            validate::run(effort, &out)
        }
        Task::Roofline { quick, out } => {
            let usual = if quick { "roofline" } else { DOCS };
            roofline::run(quick, &out.unwrap_or_else(|| usual.into()))
        }
        Task::Accuracy { quick, only, out } => {
            let usual = if quick { "accuracy" } else { DOCS };
            accuracy::run(quick, only.as_deref(), &out.unwrap_or_else(|| usual.into())).map(drop)
        }
        Task::Ale { quick, out } => {
            let usual = if quick { "ale" } else { DOCS };
            ale::run(quick, &out.unwrap_or_else(|| usual.into()))
        }
        Task::Models { quick, out } => {
            let usual = if quick { "models" } else { DOCS };
            models::run(quick, &out.unwrap_or_else(|| usual.into()))
        }
        Task::Stability { quick, out } => {
            let usual = if quick { "stability" } else { DOCS };
            stability::run(quick, &out.unwrap_or_else(|| usual.into()))
        }
        Task::Table1 {
            quick,
            sizes,
            repeats,
            out,
        } => {
            let usual = if quick { "table1" } else { DOCS };
            table1::run(&table1::Options {
                quick,
                sizes,
                repeats,
                out: &out.unwrap_or_else(|| usual.into()),
            })
        }
        Task::Iterations { quick, out } => {
            let usual = if quick { "iterations" } else { DOCS };
            iterations::run(quick, &out.unwrap_or_else(|| usual.into()))
        }
        Task::Soak { minutes, seed } => soak::run(minutes, seed),
        Task::Table1Cell { overrides } => table1::print(&overrides),
    }
}
