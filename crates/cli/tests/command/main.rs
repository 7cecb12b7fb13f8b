//! The `swim` command as a user meets it.

mod book;
mod design;
mod fuzz;
mod help;
mod hostile;
mod output;
mod pictures;
mod printed;
mod resume;
mod schemas;

use std::path::Path;
use std::process::{Command, Output};

/// Runs the command in a folder.
fn swim(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_swim"));
    command
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Standard output of a successful command.
fn printed(folder: &Path, arguments: &[&str]) -> String {
    let output = swim(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    text(&output.stdout)
}

/// Standard error of a command that is refused as bad input.
fn refused(folder: &Path, arguments: &[&str]) -> String {
    let output = swim(folder, arguments);
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    message
}

/// Runs a line of the shell in a folder, with `swim` in its path.
fn shell(folder: &Path, line: &str) -> Output {
    let program = Path::new(env!("CARGO_BIN_EXE_swim")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    let mut command = Command::new("sh");
    let command = command
        .args(["-c", line])
        .current_dir(folder)
        .env("PATH", path);
    command.output().unwrap()
}
