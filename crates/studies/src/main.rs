//! Studies that measure the workspace: `cargo xtask validate`, `cargo xtask accuracy` and others.
#![forbid(unsafe_code)]

mod accuracy;
mod ale;
mod chart;
mod iterations;
mod mesher;
mod models;
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
    after_help = "Table 1, chains of spheres and the helix: scripts in docs/figures, on the command swim"
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
    Validate {
        /// Coarser meshes and fewer rows: under two minutes on two cores.
        #[arg(long)]
        quick: bool,
        /// Only the parts whose names contain this: spheres, strokes, shapes, ...
        #[arg(long)]
        only: Option<String>,
        /// Folder for `validation.md`, `validation.csv`, the charts and the page `index.html`.
        #[arg(long, default_value = "validation")]
        out: PathBuf,
    },
    /// Speed against accuracy: drag, swimming speed and net displacement by all methods.
    Accuracy {
        #[command(flatten)]
        common: Common,
        /// Only this quantity: drag, pair, speed or net.
        #[arg(long)]
        only: Option<String>,
        /// Random instantaneous solutions and random strokes instead: errors, corrected errors and
        /// error bars.
        #[arg(long, conflicts_with_all = ["quick", "only"])]
        random: bool,
        #[command(flatten)]
        choice: accuracy::random::Choice,
    },
    /// Compares mesh motions: large steps, small steps, approach, closed cycles.
    Ale {
        #[command(flatten)]
        common: Common,
        /// Folder with Gmsh files of three spheres on the x axis: only these are studied, and only
        /// `ale-files.md` is written.
        #[arg(long)]
        files: Option<PathBuf>,
    },
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
        #[arg(long)]
        only: Option<stability::Part>,
    },
    /// Kernels of the block solver against the memory bandwidth, measured in the same run.
    Roofline(Common),
    /// Iterations of the block solver for many meshes and scenes, and its speed-up by two threads.
    Iterations(Common),
    /// Speed and quality of the mesh generator, and of the command `gmsh` if there is one.
    Mesher(Common),
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
        Task::Validate { quick, only, out } => validate::run(quick, only.as_deref(), &out),
        Task::Accuracy {
            common,
            only,
            random,
            choice,
        } => {
            let out = common.folder("accuracy", false);
            match random {
                true => accuracy::random::run(&choice, &out),
                false => accuracy::run(common.quick, only.as_deref(), &out).map(drop),
            }
        }
        Task::Ale { common, files } => {
            let out = common.folder("ale", false);
            match files {
                Some(files) => ale::run_files(&files, &out),
                None => ale::run(common.quick, &out),
            }
        }
        Task::Models(common) => models::run(common.quick, &common.folder("models", false)),
        Task::Stability { common, only } => {
            let out = common.folder("stability", only.is_some());
            match only {
                Some(part) => stability::run_part(part, common.quick, &out),
                None => stability::run(common.quick, &out),
            }
        }
        Task::Roofline(common) => roofline::run(common.quick, &common.folder("roofline", false)),
        Task::Iterations(common) => {
            iterations::run(common.quick, &common.folder("iterations", false))
        }
        Task::Mesher(common) => mesher::run(common.quick, &common.folder("mesher", false)),
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
