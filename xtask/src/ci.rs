//! The checks of CI, the same for people and machines.

use anyhow::Result;

use crate::slow::{self, Selection};
use crate::{architecture, cargo, circles, licences, links, packages, style};

/// Stated time of the slow tests that are run: the fastest that fit in ten minutes.
const SLOW_SECONDS: f64 = 600.0;

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
    // The features of the whole workspace are those of the build before.
    slow::run_selection(Selection::Within(SLOW_SECONDS), None)
}
