//! The checks of CI, the same for people and machines.

use anyhow::Result;

use crate::{architecture, cargo, circles, licences, links, packages, style};

/// Runs every check in order and stops at the first that fails.
pub fn run() -> Result<()> {
    cargo::run(&["fmt", "--all", "--check"], &[])?;
    style::run()?;
    circles::run()?;
    architecture::run()?;
    links::run()?;
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
    cargo::run(&["test", "--workspace"], &[])?;
    // Commands of the book by finite elements, which are too slow for everyday tests. The features
    // of the whole workspace are those of the build before.
    let slow = ["--workspace", "--test", "command", "--"];
    cargo::run(
        &[&["test"], &slow[..], &["--ignored", "book::"]].concat(),
        &[],
    )
}
