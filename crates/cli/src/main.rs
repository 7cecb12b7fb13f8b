//! The command `swim`: arguments in; text, files and exit codes out.
#![forbid(unsafe_code)]

mod arguments;
mod check;
mod design_files;
mod displacements;
mod error;
mod frequency;
mod help;
mod learn;
mod manual;
mod map;
mod mesh;
mod new;
mod optimise;
mod progress;
mod run;
mod sensitivities;
mod sizes;
mod solve;
mod text;
mod view;

use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Command};

fn main() -> ExitCode {
    let Arguments { quiet, command } = Arguments::parse();
    let result = match command {
        Command::Run(arguments) => run::run(arguments, quiet),
        Command::View {
            folder,
            open,
            movie,
        } => view::view(&folder, open, movie),
        Command::Solve {
            scene,
            json,
            resistance,
            flow,
            picture,
        } => solve::solve(
            &scene,
            json,
            resistance,
            flow.as_deref(),
            picture.as_deref(),
        ),
        Command::Check { scene } => check::check(&scene),
        Command::New { name, out } => new::new(&name, out),
        Command::Map(design) => map::map(design, quiet),
        Command::Optimise(design) => optimise::optimise(design, quiet),
        Command::Frequency(design) => frequency::frequency(design, quiet),
        Command::Sizes(design) => sizes::sizes(design, quiet),
        Command::Learn(design) => learn::learn_strokes(design, quiet),
        Command::Mesh { scene, out } => mesh::mesh(&scene, &out),
        Command::Completions { shell } => Ok(manual::completions(shell)),
        Command::Man { out } => manual::pages(&out),
    };
    match result {
        Ok(output) => {
            text::print(&output);
            ExitCode::SUCCESS
        }
        Err(error) => {
            text::error_message(&error.to_string());
            ExitCode::from(error.exit_code())
        }
    }
}
