//! Arguments of the command.

use std::path::PathBuf;

pub const USAGE: &str = "\
usage: mpirun -n PROCESSES swim-petsc solve SCENE.toml [--set KEY=VALUE]... [PETSC OPTIONS]
       mpirun -n PROCESSES swim-petsc run SCENE.toml [--set KEY=VALUE]... [--out DIR] [--resume]
                                      [PETSC OPTIONS]

solve computes velocities and forces at the start of the gait, run the whole gait, by finite elements
on all processes. Both print one JSON object: that of `swim solve --json`, or the summary of the run.
run writes the files of `swim run` [default: out/ and the name of the scene].

options of PETSc by role, for example:
  -ksp_monitor              residuals of the outer iteration
  -motion_ksp_view          levels of multigrid for velocities and bodies
  -pressure_ksp_view        approximation of the Schur complement
  -log_view                 times, messages and memory of all processes
";

/// What is computed.
#[derive(Debug, PartialEq)]
pub enum Task {
    /// The instantaneous solution at the start.
    Solve,
    /// The gait, with the folder for its files.
    Run { out: Option<PathBuf>, resume: bool },
}

/// Arguments of the command.
#[derive(Debug, PartialEq)]
pub struct Arguments {
    pub task: Task,
    pub scene: PathBuf,
    pub overrides: Vec<String>,
    pub of_petsc: Vec<String>,
}

impl Arguments {
    /// Reads the command line; none if it does not fit the usage.
    pub fn read(words: impl Iterator<Item = String>) -> Option<Self> {
        let mut words = words.skip(1).peekable();
        let task = match words.next()?.as_str() {
            "solve" => Task::Solve,
            "run" => Task::Run {
                out: None,
                resume: false,
            },
            _ => return None,
        };
        let mut arguments = Self {
            task,
            scene: words.next_if(|word| !word.starts_with('-'))?.into(),
            overrides: Vec::new(),
            of_petsc: Vec::new(),
        };
        while let Some(word) = words.next() {
            match (word.as_str(), &mut arguments.task) {
                ("--set", _) => arguments.overrides.push(words.next()?),
                ("--out", Task::Run { out, .. }) => *out = Some(words.next()?.into()),
                ("--resume", Task::Run { resume, .. }) => *resume = true,
                // A word without dashes is the value of the option of PETSc before it.
                (other, _) if other.starts_with("--") => return None,
                (other, _) if !other.starts_with('-') && arguments.of_petsc.is_empty() => {
                    return None;
                }
                _ => arguments.of_petsc.push(word),
            }
        }
        Some(arguments)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(line: &str) -> Option<Arguments> {
        Arguments::read(line.split(' ').map(str::to_owned))
    }

    #[test]
    fn options_of_petsc_are_told_from_our_own() {
        let line = "swim-petsc run a.toml --set x=1 -motion_ksp_max_it 2 --resume -log_view";
        let expected = Arguments {
            task: Task::Run {
                out: None,
                resume: true,
            },
            scene: "a.toml".into(),
            overrides: vec!["x=1".to_owned()],
            of_petsc: ["-motion_ksp_max_it", "2", "-log_view"]
                .map(str::to_owned)
                .into(),
        };
        assert_eq!(read(line), Some(expected));
    }

    #[test]
    fn other_words_do_not_fit() {
        for line in [
            "swim-petsc",
            "swim-petsc mesh a.toml",
            "swim-petsc solve",
            "swim-petsc solve -log_view",
            "swim-petsc solve a.toml b.toml",
            "swim-petsc solve a.toml --set",
            "swim-petsc solve a.toml --resume",
            "swim-petsc run a.toml --unknown",
        ] {
            assert_eq!(read(line), None, "{line}");
        }
    }
}
