//! Arguments of the command line.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use clap_complete::Shell;
use swimmer::Scene;
use swimmer::models::TablePart;

use super::error::CliError;
use super::progress::Waiting;
use super::{help, text};

/// Simulates rigid bodies and articulated micro-swimmers in Stokes flow
#[derive(Parser)]
#[command(name = "swim", version, about, after_help = help::SWIM)]
pub struct Arguments {
    /// Print no progress to stderr, and of a run one line; warnings and errors remain
    #[arg(short, long, global = true)]
    pub quiet: bool,
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    /// Simulate the gait; write report.html, summary.json, trajectory.csv, trajectory.svg and
    /// ParaView files
    #[command(after_help = help::RUN)]
    Run(RunArguments),
    /// Write report.html of an earlier run again, from the files in its folder
    #[command(after_help = help::VIEW)]
    View {
        /// The folder of the run
        #[arg(value_name = "DIR")]
        folder: PathBuf,
        /// Open the page in the browser
        #[arg(long)]
        open: bool,
        /// Write movie.svg, the flow in a plane over the first cycle
        #[arg(long)]
        movie: bool,
    },
    /// Compute velocities and forces at the start of the first phase of the gait
    #[command(after_help = help::SOLVE)]
    Solve {
        #[command(flatten)]
        scene: SceneArguments,
        /// The steady flow with inertia of the fluid (fluid.density), in the frame of the bodies
        #[arg(long, conflicts_with_all = ["resistance", "picture"])]
        steady: bool,
        /// Print the result as one JSON object
        #[arg(long)]
        json: bool,
        /// Add the grand resistance matrix of the bodies without joints (six more solves per body)
        #[arg(long)]
        resistance: bool,
        /// Write the flow field for ParaView
        #[arg(long, value_name = "FILE.vtu")]
        flow: Option<PathBuf>,
        /// Draw the flow in a plane: streamlines, and as colour the speed, or the viscosity where
        /// it varies
        #[arg(long, value_name = "FILE.svg")]
        picture: Option<PathBuf>,
    },
    /// Tabulate the connection over the shapes; draw its curvature, with the gait
    #[command(after_help = help::MAP)]
    Map(MapArguments),
    /// Search the best stroke; write it as a scene, optimum.toml
    #[command(after_help = help::OPTIMISE)]
    Optimise(DesignArguments),
    /// Search the frequency of the largest net displacement per cycle; write frequency.csv
    #[command(after_help = help::FREQUENCY)]
    Frequency(DesignArguments),
    /// Search the best radii and arm lengths for the gait; write optimum.toml and sizes.csv
    #[command(after_help = help::SIZES)]
    Sizes(DesignArguments),
    /// Learn a stroke by reinforcement; compare it with the best possible one
    #[command(after_help = help::LEARN)]
    Learn(DesignArguments),
    /// Run the scene with other values of some keys; write sweep.csv and sweep.svg
    #[command(after_help = help::SWEEP)]
    Sweep(SweepArguments),
    /// Check the scene; print the model that would be chosen and its cost
    #[command(after_help = help::CHECK)]
    Check {
        #[command(flatten)]
        scene: SceneArguments,
    },
    /// Write an example scene, such as three-sphere, purcell or squirmer
    #[command(after_help = help::NEW)]
    New {
        /// Name of the example; without it the names of all are printed
        #[arg(value_name = "NAME")]
        name: Option<String>,
        /// Print the names of all examples
        #[arg(long, conflicts_with_all = ["name", "out"])]
        list: bool,
        /// The scene file [default: NAME.toml]
        #[arg(long, value_name = "FILE", requires = "name")]
        out: Option<PathBuf>,
    },
    /// Write the mesh of the initial shape; print its size and quality
    #[command(after_help = help::MESH)]
    Mesh {
        #[command(flatten)]
        scene: SceneArguments,
        /// The mesh file, .vtu (ParaView) or .msh (Gmsh)
        #[arg(long, value_name = "FILE")]
        out: PathBuf,
    },
    /// Print the JSON schema of an output, such as that of --json; without a name, list them
    #[command(after_help = help::SCHEMA)]
    Schema {
        /// Name of the schema, mostly that of a command
        #[arg(value_name = "NAME")]
        name: Option<String>,
    },
    /// Print the completions of a shell, to be saved where the shell looks for them
    #[command(after_help = help::COMPLETIONS)]
    Completions {
        /// The shell
        shell: Shell,
    },
    /// Write the manual pages of the command and its subcommands
    #[command(after_help = help::MAN)]
    Man {
        /// Folder for the pages, such as ~/.local/share/man/man1
        #[arg(value_name = "DIR")]
        out: PathBuf,
    },
}

/// Arguments of `swim run`.
#[derive(Args)]
pub struct RunArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Folder for the results [default: out/NAME, the name of the scene]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Continue an interrupted run from its checkpoint in the folder
    #[arg(long)]
    pub resume: bool,
    /// Print the summary as one JSON object
    #[arg(long)]
    pub json: bool,
    /// Add the derivatives of the net displacement with respect to radii, lengths, amplitudes and
    /// springs (four more runs each); write sensitivities.csv
    #[arg(long)]
    pub sensitivities: bool,
    /// Open report.html in the browser
    #[arg(long)]
    pub open: bool,
    /// Write movie.svg, the flow in a plane over the first cycle
    #[arg(long)]
    pub movie: bool,
}

/// Arguments of the commands that design strokes.
#[derive(Args)]
pub struct DesignArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// Folder for the results [default: out/NAME, the name of the scene]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the result as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `swim sweep`.
#[derive(Args)]
pub struct SweepArguments {
    #[command(flatten)]
    pub scene: SceneArguments,
    /// A key and its values: key=from:to:count, also with :log for equal ratios, or
    /// key=value,value,...; all combinations are run. Also links.NAME.length, for which bodies are
    /// moved and the gait is shifted, and links.NAME.amplitude
    #[arg(long, value_name = "KEY=VALUES", required = true)]
    pub vary: Vec<String>,
    /// Run this number of random points instead; the values are key=from:to, also with :log, or
    /// key=value,value,...
    #[arg(long, value_name = "COUNT")]
    pub random: Option<usize>,
    /// Seed of the random points
    #[arg(long, value_name = "SEED", default_value_t = 1, requires = "random")]
    pub seed: u64,
    /// Number of runs at the same time [default: number of threads]
    #[arg(long, value_name = "COUNT")]
    pub jobs: Option<usize>,
    /// Continue an interrupted sweep in the folder
    #[arg(long)]
    pub resume: bool,
    /// Folder for the results [default: out/NAME, the name of the scene]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print the rows as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `swim map`.
#[derive(Args)]
pub struct MapArguments {
    #[command(flatten)]
    pub design: DesignArguments,
    /// Solve shard I of N of the shapes and store it in the folder, the same for all shards
    #[arg(long, value_name = "I/N", value_parser = share)]
    shard: Option<TablePart>,
    /// Complete the table from the shards in the folder; fail if shapes are missing
    #[arg(long, conflicts_with = "shard")]
    merge: bool,
}

impl MapArguments {
    /// The shapes to be solved.
    pub fn part(&self) -> TablePart {
        match self.merge {
            true => TablePart::Known,
            false => self.shard.unwrap_or(TablePart::Whole),
        }
    }
}

/// The share `i/n`.
fn share(text: &str) -> Result<TablePart, String> {
    let numbers = text.split_once('/');
    let numbers = numbers.and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((number, count)) if (1..=count).contains(&number) => {
            Ok(TablePart::Share { number, count })
        }
        _ => Err("a share is i/n with i from 1 to n, such as 2/8".to_owned()),
    }
}

#[derive(Args)]
pub struct SceneArguments {
    /// The scene file
    #[arg(value_name = "SCENE.toml")]
    path: PathBuf,
    /// Override a key of the scene, for example gait.cycles=3 or bodies.left.radius=0.5
    #[arg(long = "set", value_name = "KEY=VALUE")]
    overrides: Vec<String>,
}

impl SceneArguments {
    /// Reads the scene and applies the overrides, which takes seconds where files are large or
    /// surfaces may fold; says so unless `quiet`.
    pub fn read(&self, quiet: bool) -> Result<Scene, CliError> {
        let waiting = Waiting::new("reading the scene", quiet);
        let scene = Scene::read(&self.path, &self.overrides)?;
        drop(waiting);
        scene.warnings().iter().for_each(|text| text::warn(text));
        Ok(scene)
    }
}
