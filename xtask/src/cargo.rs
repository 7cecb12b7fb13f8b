//! Calls of cargo.

use std::process::Command;

use anyhow::{Context, Result, bail};

/// Command that starts, with these arguments, the same cargo that started this program.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(arguments);
    command
}

/// Runs cargo with arguments and additional environment variables.
///
/// # Errors
/// Cargo that cannot be started, or that fails.
pub fn run(arguments: &[&str], environment: &[(&str, &str)]) -> Result<()> {
    eprintln!("== cargo {}", arguments.join(" "));
    let status = command(arguments)
        .envs(environment.iter().copied())
        .status()
        .with_context(|| format!("could not start cargo {}", arguments.join(" ")))?;
    if !status.success() {
        bail!("cargo {} failed: {status}", arguments.join(" "));
    }
    Ok(())
}
