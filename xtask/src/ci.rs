//! The checks of CI, the same for people and machines.

use anyhow::Result;

use crate::{architecture, cargo, licences, packages, style};

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
    packages::run()?;
    // The same command as in the README.
    cargo::run(&["test", "--workspace"], &[])
}
