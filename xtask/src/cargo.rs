//! Calls of cargo.

use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::files::root;

/// Command that starts, with these arguments, the same cargo that started this program.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments);
    command
}

/// Runs cargo at the root of the workspace with arguments and additional environment variables.
///
/// # Errors
/// Cargo that cannot be started, or that fails.
pub fn run(arguments: &[&str], environment: &[(&str, &str)]) -> Result<()> {
    eprintln!("== cargo {}", arguments.join(" "));
    let status = command(arguments)
        .current_dir(root())
        .envs(environment.iter().copied())
        .status()
        .with_context(|| format!("could not start cargo {}", arguments.join(" ")))?;
    if !status.success() {
        bail!("cargo {} failed: {status}", arguments.join(" "));
    }
    Ok(())
}

/// What cargo prints at the root of the workspace with these arguments; its messages go to the
/// terminal.
///
/// # Errors
/// Cargo that cannot be started, or that fails.
pub fn output(arguments: &[&str]) -> Result<String> {
    let output = command(arguments)
        .current_dir(root())
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("could not start cargo {}", arguments.join(" ")))?;
    if !output.status.success() {
        bail!("cargo {} failed: {}", arguments.join(" "), output.status);
    }
    String::from_utf8(output.stdout).context("cargo printed no UTF-8")
}
