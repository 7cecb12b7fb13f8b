//! Studies that measure the workspace: `cargo xtask validate`, `cargo xtask table1` and others.
#![forbid(unsafe_code)]

mod accuracy;
mod ale;
mod chains;
mod chart;
mod folder;
mod helix;
mod iterations;
mod linear_chart;
mod machine;
mod mesher;
mod models;
mod multiple_rhs;
mod page;
mod random;
mod reference;
mod roofline;
mod scene_files;
mod soak;
mod stability;
mod table1;
mod tolerances;
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
        /// Two mesh sizes: a minute on two cores.
        #[arg(long)]
        quick: bool,
        /// Only this quantity: drag, pair, speed or net.
        #[arg(long)]
        only: Option<String>,
        /// Random instantaneous solutions and random strokes instead: errors, corrected errors and
        /// error bars.
        #[arg(long, conflicts_with_all = ["quick", "only"])]
        random: bool,
        /// Number of random instantaneous solutions.
        #[arg(long, default_value_t = 100, requires = "random")]
        instants: usize,
        /// Number of random instantaneous solutions of bodies with slip.
        #[arg(long, default_value_t = 20, requires = "random")]
        squirmers: usize,
        /// Number of random strokes.
        #[arg(long, default_value_t = 30, requires = "random")]
        strokes: usize,
        /// Seed of the first random case; each following one has the next seed.
        #[arg(long, default_value_t = 1, requires = "random")]
        seed: u64,
        /// Continues with the cases of `random.csv` in the folder.
        #[arg(long, requires = "random")]
        resume: bool,
        /// Folder for `accuracy.md`, `accuracy.csv` and the charts, or `random.md` and
        /// `random.csv` [default: docs, or accuracy for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Compares mesh motions: large steps, small steps, approach, closed cycles.
    Ale {
        /// A coarse mesh and two cycles: half a minute on two cores.
        #[arg(long)]
        quick: bool,
        /// Folder with Gmsh files of three spheres on the x axis: only these are studied, and only
        /// `ale-files.md` is written.
        #[arg(long)]
        files: Option<PathBuf>,
        /// Folder for `ale.md`, `ale.csv`, charts and pictures [default: docs, or ale for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Error bars and true errors of all models on scenes with exact solutions.
    ///
    /// Fails if a true error is larger than its bar allows.
    Models {
        /// Without finite elements: takes seconds.
        #[arg(long)]
        quick: bool,
        /// Folder for `models.md` and `models.csv` [default: docs, or models for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// The stability map: formulations x solvers x stress cases, each right or refused with a
    /// reason.
    Stability {
        /// The part that the tests run.
        #[arg(long)]
        quick: bool,
        /// One map only, printed and not written to files.
        #[arg(long)]
        only: Option<stability::Part>,
        /// Folder for `stability.md` and `stability.csv` [default: docs, or stability for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Repeats Table 1 of the paper: formulations x solvers x sizes; about an hour at full size.
    Table1 {
        /// One small mesh: a minute on two cores.
        #[arg(long)]
        quick: bool,
        /// Number of mesh sizes, from the smallest on: 1 to 3.
        #[arg(long, default_value_t = 3)]
        sizes: usize,
        /// Number of rounds; times of the block solver are medians over them.
        #[arg(long, default_value_t = 3)]
        repeats: usize,
        /// Folder for `table1.md`, `table1.csv` and `table1.svg` [default: docs, or table1 for
        /// --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Kernels of the block solver against the memory bandwidth, measured in the same run.
    Roofline {
        /// One small mesh: half a minute on two cores.
        #[arg(long)]
        quick: bool,
        /// Folder for `roofline.md` and `roofline.csv` [default: docs, or roofline for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Iterations of the block solver for many meshes and scenes, and its speed-up by two threads.
    Iterations {
        /// Small meshes: two minutes on two cores.
        #[arg(long)]
        quick: bool,
        /// Folder for `iterations.md` [default: docs, or iterations for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// Speed and quality of the mesh generator, beside those of the command `gmsh` if there is one.
    Mesher {
        /// One size: half a minute on two cores.
        #[arg(long)]
        quick: bool,
        /// Folder for `mesher.md` [default: docs, or mesher for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// The best strokes of chains of three to six spheres, beside the learned ones.
    Chains {
        /// Three spheres: takes seconds.
        #[arg(long)]
        quick: bool,
        /// Folder for `chains.md` and `chains.svg` [default: docs, or chains for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// A helix under a torque, beside resistive-force theory.
    Helix {
        /// One size and two angles: half a minute on two cores.
        #[arg(long)]
        quick: bool,
        /// Folder for `helix.md` and `helix.svg` [default: docs, or helix for --quick].
        #[arg(long)]
        out: Option<PathBuf>,
    },
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
        /// Number of strokes.
        #[arg(long, default_value_t = 1000)]
        cases: usize,
        /// Seed of the random numbers; the same seed gives the same strokes.
        #[arg(long, default_value_t = 1)]
        seed: u64,
        /// Folder for `tolerances.md` and `tolerances.csv` [default: docs].
        #[arg(long)]
        out: Option<PathBuf>,
    },
    /// One cell of Table 1, started by `table1` as a separate process.
    #[command(hide = true)]
    Table1Cell { overrides: Vec<String> },
}

/// Folder of the project's documents, to which full runs write.
const DOCS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs");

fn main() -> Result<()> {
    match Arguments::parse().task {
        Task::Validate { quick, only, out } => {
            let effort = if quick {
                validate::Effort::Quick
            } else {
                validate::Effort::Full
            };
            validate::run(effort, only.as_deref(), &out)
        }
        Task::Roofline { quick, out } => {
            let out = output_folder(out, quick, "roofline");
            roofline::run(quick, &out)
        }
        Task::Accuracy {
            quick,
            only,
            random,
            instants,
            squirmers,
            strokes,
            seed,
            resume,
            out,
        } => {
            let out = output_folder(out, quick, "accuracy");
            match random {
                true => accuracy::random::run([instants, squirmers, strokes], seed, resume, &out),
                false => accuracy::run(quick, only.as_deref(), &out).map(drop),
            }
        }
        Task::Ale { quick, files, out } => {
            let out = output_folder(out, quick, "ale");
            match files {
                Some(files) => ale::run_files(&files, &out),
                None => ale::run(quick, &out),
            }
        }
        Task::Models { quick, out } => {
            let out = output_folder(out, quick, "models");
            models::run(quick, &out)
        }
        Task::Stability { quick, only, out } => {
            let out = output_folder(out, quick || only.is_some(), "stability");
            match only {
                Some(part) => stability::run_part(part, quick, &out),
                None => stability::run(quick, &out),
            }
        }
        Task::Table1 {
            quick,
            sizes,
            repeats,
            out,
        } => {
            let out = output_folder(out, quick, "table1");
            table1::run(&table1::Options {
                quick,
                sizes,
                repeats,
                out: &out,
            })
        }
        Task::Iterations { quick, out } => {
            let out = output_folder(out, quick, "iterations");
            iterations::run(quick, &out)
        }
        Task::Mesher { quick, out } => {
            let out = output_folder(out, quick, "mesher");
            mesher::run(quick, &out)
        }
        Task::Chains { quick, out } => chains::run(quick, &output_folder(out, quick, "chains")),
        Task::Helix { quick, out } => helix::run(quick, &output_folder(out, quick, "helix")),
        Task::Tolerances { cases, seed, out } => {
            tolerances::run(cases, seed, &output_folder(out, false, ""))
        }
        Task::Soak { minutes, seed } => soak::run(minutes, seed),
        Task::Table1Cell { overrides } => table1::print(&overrides),
    }
}

/// Folder to write to: the one chosen, or `quick_name` for a quick run, or the documents.
fn output_folder(chosen: Option<PathBuf>, quick: bool, quick_name: &str) -> PathBuf {
    chosen.unwrap_or_else(|| if quick { quick_name } else { DOCS }.into())
}
