//! The command `swim-petsc`: scenes solved on all processes of a job.
//!
//! Every process reads the scene and makes the same mesh and the same decisions; the first one
//! prints. Words that start with a single dash are options of PETSc.
#![forbid(unsafe_code)]

use std::path::Path;
use std::process::ExitCode;

use petsc::{PetscEngine, Session};
use swimmer::models::FemModel;
use swimmer::output::solution_json;
use swimmer::{Scene, SwimError, solve_start};

const USAGE: &str = "\
usage: mpirun -n PROCESSES swim-petsc solve SCENE.toml [--set KEY=VALUE]... [PETSC OPTIONS]

Computes velocities and forces at the start of the gait by finite elements on all processes, and
prints them as one JSON object, as `swim solve --json` does.

options of PETSc by role, for example:
  -ksp_monitor              residuals of the outer iteration
  -motion_ksp_view          levels of multigrid for velocities and bodies
  -pressure_ksp_view        approximation of the Schur complement
  -log_view                 times, messages and memory of all processes
";

static ENGINE: PetscEngine = PetscEngine;

/// Arguments of the command.
struct Arguments {
    scene: String,
    overrides: Vec<String>,
    of_petsc: Vec<String>,
}

impl Arguments {
    /// Reads the command line; none if it does not fit the usage.
    fn read(words: impl Iterator<Item = String>) -> Option<Self> {
        let mut words = words.skip(1).peekable();
        words.next_if(|word| word == "solve")?;
        let mut arguments = Self {
            scene: words.next_if(|word| !word.starts_with('-'))?,
            overrides: Vec::new(),
            of_petsc: Vec::new(),
        };
        while let Some(word) = words.next() {
            if word == "--set" {
                arguments.overrides.push(words.next()?);
            } else if word.starts_with("--")
                || arguments.of_petsc.is_empty() && !word.starts_with('-')
            {
                return None;
            } else {
                // An option, or the value of one.
                arguments.of_petsc.push(word);
            }
        }
        Some(arguments)
    }
}

fn main() -> ExitCode {
    let Some(arguments) = Arguments::read(std::env::args()) else {
        eprint!("{USAGE}");
        return ExitCode::from(2);
    };
    let session = match Session::start(&arguments.of_petsc) {
        Ok(session) => session,
        Err(error) => {
            eprintln!("error: {error}");
            return ExitCode::from(3);
        }
    };
    match solve(&arguments) {
        Ok(answer) => {
            if session.rank() == 0 {
                println!("{answer}");
            }
            ExitCode::SUCCESS
        }
        Err(error) => {
            // Other processes may wait for this one.
            eprintln!("error on process {}: {error}", session.rank());
            session.abort(error.exit_code())
        }
    }
}

/// The solution at the start of the scene as one JSON object.
fn solve(arguments: &Arguments) -> Result<String, SwimError> {
    let scene = Scene::read(Path::new(&arguments.scene), &arguments.overrides)?;
    let mut model = FemModel::new(&scene)?.with_engine(&ENGINE);
    let solution = solve_start(&scene, &mut model)?;
    Ok(solution_json(&scene, "fem", &solution).to_string())
}
