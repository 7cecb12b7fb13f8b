//! The checks of CI, the same for people and machines.

use anyhow::Result;

use crate::{architecture, cargo, licences, style};

/// Runs every check in order and stops at the first that fails.
pub fn run() -> Result<()> {
    cargo::run(&["fmt", "--all", "--check"], &[])?;
    style::run()?;
    architecture::run()?;
    cargo::run(
        &[
            "clippy",
            "--workspace",
            "--all-targets",
            "--locked",
            "--",
            "-D",
            "warnings",
        ],
        &[],
    )?;
    cargo::run(
        &["doc", "--workspace", "--no-deps", "--locked"],
        &[("RUSTDOCFLAGS", "-D warnings")],
    )?;
    licences::run()?;
    // Exactly the README's test command.
    cargo::run(&["test", "--workspace"], &[])
}
