//! Studies that measure the workspace: `cargo xtask validate`, `cargo xtask stability` and others.
#![forbid(unsafe_code)]

mod ale;
mod chart;
mod models;
mod newton;
mod oseen;
mod page;
mod random;
mod reference;
mod roofline;
mod scenes;
mod soak;
mod stability;
mod table;
mod three_spheres;
mod tolerances;
mod validate;

use std::path::PathBuf;

use anyhow::Result;
use clap::{Args, Parser, Subcommand};

#[derive(Parser)]
#[command(
    name = "cargo xtask",
    about = "Studies that measure the workspace",
    after_help = "Figures that need the command swim only are scripts in docs/figures"
)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

/// Size and place of a study.
#[derive(Args)]
struct Common {
    /// A smaller study, of at most two minutes on two cores.
    #[arg(long)]
    quick: bool,
    /// Folder for the pages, tables and charts [default: docs, or a folder of the study's name for
    /// --quick].
    #[arg(long)]
    out: Option<PathBuf>,
}

impl Common {
    /// Folder to write to: the one chosen, or `name` for a part of a study, or the documents.
    fn folder(&self, name: &str, is_part: bool) -> PathBuf {
        const DOCS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs");
        let default = if self.quick || is_part { name } else { DOCS };
        self.out.clone().unwrap_or_else(|| default.into())
    }
}

#[derive(Subcommand)]
enum Task {
    /// Compares computed with exact values; fails if an error is above its tolerance.
    ///
    /// Writes `validation.md`, `validation.csv`, a chart and the page `index.html`, by default to
    /// the folder `validation`.
    Validate {
        #[command(flatten)]
        common: Common,
        /// Only the parts whose names contain this: spheres, strokes, shapes, ...
        #[arg(long)]
        only: Option<String>,
    },
    /// Compares mesh motions: large steps, small steps, approach, closed cycles.
    Ale(Common),
    /// Error bars and true errors of all models on scenes with exact solutions.
    ///
    /// Fails if a true error is larger than its bar allows. The quick part has no finite elements.
    Models(Common),
    /// The stability map: formulations x solvers x stress cases, each right or refused with a
    /// reason.
    Stability {
        #[command(flatten)]
        common: Common,
        /// One map only, printed and not written to files.
        #[arg(long, conflicts_with = "keep")]
        only: Option<stability::Part>,
        /// Keeps the rows of stability.csv in the folder and computes missing ones only, for new
        /// stress cases.
        #[arg(long)]
        keep: bool,
    },
    /// Kernels of the block solver against the memory bandwidth, measured in the same run.
    Roofline(Common),
    /// Iterations of the block solver for flows with inertia: Reynolds numbers, meshes, containers.
    Oseen(Common),
    /// Iterations of Newton's method and its linear solves for fluids with a viscosity law.
    Newton(Common),
    /// Runs random scenes with all models: checks balances, reproducibility and memory.
    Soak {
        /// Duration of the run.
        #[arg(long, default_value_t = 30.0)]
        minutes: f64,
        /// Seed of the random numbers; the same seed gives the same scenes.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
    /// Random strokes at random tolerances by all models: the error is within the bar and the bar
    /// within the tolerance, or the run is refused.
    Tolerances {
        #[command(flatten)]
        common: Common,
        /// Number of strokes [default: 1000, or 50 for --quick].
        #[arg(long)]
        cases: Option<usize>,
        /// Seed of the random numbers; the same seed gives the same strokes.
        #[arg(long, default_value_t = 1)]
        seed: u64,
    },
}

fn main() -> Result<()> {
    match Arguments::parse().task {
        Task::Validate { common, only } => {
            let out = common.folder("validation", true);
            validate::run(common.quick, only.as_deref(), &out)
        }
        Task::Ale(common) => ale::run(common.quick, &common.folder("ale", false)),
        Task::Models(common) => models::run(common.quick, &common.folder("models", false)),
        Task::Stability { common, only, keep } => {
            let out = common.folder("stability", only.is_some());
            match only {
                Some(part) => stability::run_part(part, common.quick, &out),
                None => stability::run(common.quick, keep, &out),
            }
        }
        Task::Roofline(common) => roofline::run(common.quick, &common.folder("roofline", false)),
        Task::Oseen(common) => oseen::run(common.quick, &common.folder("oseen", false)),
        Task::Newton(common) => newton::run(common.quick, &common.folder("newton", false)),
        Task::Soak { minutes, seed } => soak::run(minutes, seed),
        Task::Tolerances {
            common,
            cases,
            seed,
        } => {
            let cases = cases.unwrap_or(if common.quick { 50 } else { 1000 });
            tolerances::run(cases, seed, &common.folder("tolerances", false))
        }
    }
}
