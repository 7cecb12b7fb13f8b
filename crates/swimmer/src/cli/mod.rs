//! The command line: arguments in; text, files and exit codes out.

mod arguments;
mod check;
mod design_files;
mod design_progress;
mod displacements;
mod learn;
mod map;
mod mesh;
mod new;
mod optimise;
mod progress;
mod run;
mod sensitivities;
mod solve;
mod text;
mod view;

use std::process::ExitCode;

use clap::Parser;

use arguments::{Arguments, Command};

/// Runs the command and returns its exit code, see [`swimmer::SwimError::exit_code`].
pub fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Run {
            scene,
            out,
            resume,
            sensitivities,
            open,
        } => run::run(&scene, out, resume, sensitivities, open),
        Command::View { folder, open } => view::view(&folder, open),
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
        Command::Map(design) => map::map(design),
        Command::Optimise(design) => optimise::optimise(design),
        Command::Learn(design) => learn::learn_strokes(design),
        Command::Mesh { scene, out } => mesh::mesh(&scene, &out),
    };
    match result {
        Ok(output) => {
            text::print(&output);
            ExitCode::SUCCESS
        }
        Err(error) => {
            text::message(&format!("error: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}
