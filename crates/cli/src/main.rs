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
mod map;
mod mesh;
mod neglected;
mod optimise;
mod progress;
mod run;
mod schemas;
mod sizes;
mod solve;
mod sweep;
mod text;
mod time_left;
mod view;

use std::path::Path;
use std::process::ExitCode;

use clap::{CommandFactory, Parser};
use clap_complete::Shell;
use swimmer::SwimError;

use arguments::{Arguments, Command};
use error::CliError;

fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if error.use_stderr() => error.exit(),
        Err(help) => return ended(text::check_printed(help.print())),
    };
    progress::watch_file_limit();
    let result = swimmer::check_threads().map_err(CliError::from);
    let result = result.and_then(|()| execute(arguments));
    ended(result.and_then(|output| text::print(&output)))
}

/// Prints an error, and returns the exit code.
fn ended(result: Result<(), CliError>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            text::error_message(&error.to_string());
            ExitCode::from(error.exit_code())
        }
    }
}

/// Executes the command; returns the text for stdout.
fn execute(Arguments { quiet, command }: Arguments) -> Result<String, CliError> {
    match command {
        Command::Run(arguments) => run::run(arguments, quiet),
        Command::View {
            folder,
            open,
            movie,
        } => view::view(&folder, open, movie),
        Command::Solve {
            scene,
            steady: true,
            json,
            flow,
            ..
        } => solve::solve_steady_state(&scene, json, flow.as_deref(), quiet),
        Command::Solve {
            scene,
            steady: false,
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
            quiet,
        ),
        Command::Check { scene } => check::check(&scene, quiet),
        Command::New { name, out, .. } => match name {
            Some(name) => check::new(&name, out),
            None => Ok(check::examples()),
        },
        Command::Map(design) => map::map(design, quiet),
        Command::Optimise(design) => optimise::optimise(design, quiet),
        Command::Frequency(design) => frequency::frequency(design, quiet),
        Command::Sizes(design) => sizes::sizes(design, quiet),
        Command::Sweep(arguments) => sweep::sweep_scene(arguments, quiet),
        Command::Learn(design) => learn::learn_strokes(design, quiet),
        Command::Mesh { scene, out } => mesh::mesh(&scene, &out, quiet),
        Command::Schema { name } => schemas::schema(name.as_deref()),
        Command::Completions { shell } => Ok(completions(shell)),
        Command::Man { out } => manual_pages(&out),
    }
}

/// The completions of a shell.
fn completions(shell: Shell) -> String {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Arguments::command(), "swim", &mut script);
    String::from_utf8_lossy(&script).into_owned()
}

/// Writes the manual pages into a folder, one per subcommand.
fn manual_pages(out: &Path) -> Result<String, CliError> {
    std::fs::create_dir_all(out)
        .and_then(|()| clap_mangen::generate_to(Arguments::command(), out))
        .map_err(|source| SwimError::Write {
            path: out.to_owned(),
            source,
        })?;
    Ok(text::entry("manual pages", out.display()))
}
