//! The command `swim-petsc`: scenes solved on all processes of a job.
//!
//! Every process reads the scene and makes the same mesh and the same decisions; the first one
//! prints. Words that start with a single dash are options of PETSc.
#![forbid(unsafe_code)]

mod arguments;

use std::io::{ErrorKind, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use arguments::{Arguments, Task, USAGE};
use petsc::{PetscEngine, Session};
use pictures::RunPictures;
use swimmer::models::{FemModel, ModelError};
use swimmer::output::solution_json;
use swimmer::{Choice, Progress, Scene, SwimError, run_with, solve_start};

static ENGINE: PetscEngine = PetscEngine;

fn main() -> ExitCode {
    let Some(arguments) = Arguments::read(std::env::args()) else {
        message(USAGE);
        return ExitCode::from(2);
    };
    let session = match Session::start(&arguments.of_petsc) {
        Ok(session) => session,
        Err(error) => {
            message(&format!("error: {error}\n"));
            return ExitCode::from(3);
        }
    };
    match answer(&arguments, session.rank() == 0) {
        Ok(answer) => {
            // Other processes have nothing to print.
            let printed = match session.rank() {
                0 => print(&answer),
                _ => Ok(()),
            };
            match printed {
                Ok(()) => ExitCode::SUCCESS,
                Err(error) => {
                    message(&format!(
                        "error: cannot write the result to standard output: {error}; free space \
                         there, or redirect it\n"
                    ));
                    ExitCode::from(2)
                }
            }
        }
        Err(error) => {
            // Other processes may wait for this one.
            message(&format!("error on process {}: {error}\n", session.rank()));
            session.abort(error.exit_code())
        }
    }
}

/// Writes to stderr. A closed stderr is no error.
fn message(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}

/// Writes a line to stdout. A closed stdout is no error: its reader has what it wanted.
fn print(answer: &str) -> std::io::Result<()> {
    let mut stdout = std::io::stdout().lock();
    match writeln!(stdout, "{answer}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error),
        _ => Ok(()),
    }
}

/// The answer to the command as one JSON object.
fn answer(arguments: &Arguments, is_first: bool) -> Result<String, SwimError> {
    let scene = Scene::read(&arguments.scene, &arguments.overrides)?;
    match &arguments.task {
        Task::Solve => {
            let mut model = model(&scene)?.model;
            let solution = solve_start(&scene, model.as_mut())?;
            Ok(solution_json(&scene, model.name(), &solution).to_string())
        }
        Task::Run { out, resume } => {
            let default = || PathBuf::from("out").join(scene.name());
            let out = out.clone().unwrap_or_else(default);
            let files = &mut RunPictures::new();
            let model = |scene: &Scene, _: &mut dyn Progress| model(scene);
            let report =
                run_with(scene, &model, &out, *resume, is_first, files, &mut ())?.completed()?;
            report.check_tolerance()?;
            Ok(report.summary().to_string())
        }
    }
}

/// Finite elements that are solved on all processes.
fn model(scene: &Scene) -> Result<Choice, ModelError> {
    Ok(Choice::new(
        Box::new(FemModel::new(scene)?.with_engine(&ENGINE)),
        vec!["finite elements are the model that PETSc solves".to_owned()],
    ))
}
