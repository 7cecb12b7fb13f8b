//! The command line: arguments in, text, files and exit codes out.

mod check;
mod mesh;
mod new;
mod progress;
mod run;
mod solve;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use swimmer::models::ErrorEstimate;
use swimmer::{Scene, SwimError};

/// Rigid bodies and articulated micro-swimmers in Stokes flow.
#[derive(Parser)]
#[command(name = "swim", version, about)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Simulate the gait; write summary.json, trajectory.csv, trajectory.svg and ParaView files
    Run {
        #[command(flatten)]
        scene: SceneArguments,
        /// Folder for the results [default: out/ and the scene's name]
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Go on from the checkpoint of an interrupted run
        #[arg(long)]
        resume: bool,
    },
    /// Solve the instant at the start of the gait's first phase
    Solve {
        #[command(flatten)]
        scene: SceneArguments,
        /// Print one JSON object
        #[arg(long)]
        json: bool,
        /// Add the grand resistance matrix of the bodies, links apart: six more solves a body
        #[arg(long)]
        resistance: bool,
        /// Write the flow for ParaView
        #[arg(long, value_name = "FILE.vtu")]
        flow: Option<PathBuf>,
    },
    /// Validate the scene; name the model that would be used and its cost
    Check {
        #[command(flatten)]
        scene: SceneArguments,
    },
    /// Write a scene file to start from: three-sphere, chain, planar or tetrahedral
    New {
        /// The template
        #[arg(value_name = "NAME")]
        name: String,
        /// The scene file [default: the template's name and .toml]
        #[arg(long, value_name = "FILE")]
        out: Option<PathBuf>,
    },
    /// Write the mesh of the starting shape and its quality
    Mesh {
        #[command(flatten)]
        scene: SceneArguments,
        /// The mesh file, .vtu or .msh
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
}

#[derive(Args)]
struct SceneArguments {
    /// The scene file
    #[arg(value_name = "SCENE.toml")]
    path: PathBuf,
    /// Override a key of the scene: gait.cycles=3, bodies.left.radius=0.5
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

impl SceneArguments {
    fn read(&self) -> Result<Scene, SwimError> {
        Ok(Scene::read(&self.path, &self.overrides)?)
    }
}

pub fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Run { scene, out, resume } => run::run(&scene, out, resume),
        Command::Solve {
            scene,
            json,
            resistance,
            flow,
        } => solve::solve(&scene, json, resistance, flow.as_deref()),
        Command::Check { scene } => check::check(&scene),
        Command::New { name, out } => new::new(&name, out),
        Command::Mesh { scene, out } => mesh::mesh(&scene, &out),
    };
    match outcome {
        Ok(text) => {
            // A reader that closed the pipe has seen what it wanted.
            let _ = std::io::stdout().write_all(text.as_bytes());
            ExitCode::SUCCESS
        }
        Err(error) => {
            say(&format!("error: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}

/// One line on stderr; that nobody listens is no reason to stop.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Error bars, apart and summed.
fn errors(estimate: &ErrorEstimate) -> String {
    let sources: Vec<String> = estimate
        .sources()
        .iter()
        .map(|(name, error)| {
            error.map_or(format!("{name} not estimated"), |error| {
                format!("{name} {error:.1e}")
            })
        })
        .collect();
    format!(
        "error {:.1e} of what was estimated: {}",
        estimate.total(),
        sources.join(", ")
    )
}

/// Seconds as people say them.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.0} µs", 1e6 * s),
        s if s < 1.0 => format!("{:.0} ms", 1e3 * s),
        s if s < 120.0 => format!("{s:.1} s"),
        s => format!("{:.0} min", s / 60.0),
    }
}
