//! The checks of CI, the same for people and machines.

use std::fs::OpenOptions;
use std::io::Write as _;

use anyhow::Result;

use crate::slow::{self, Selection};
use crate::{
    architecture, cargo, circles, documentation, generated, licences, links, packages, readmes,
    style,
};

/// Stated time of the slow tests that are run: the fastest that fit in ten minutes.
const SLOW_SECONDS: f64 = 600.0;

/// Packages that are workspaces of their own.
const OTHER_WORKSPACES: [&str; 3] = [
    "python/Cargo.toml",
    "crates/petsc/Cargo.toml",
    "fuzz/Cargo.toml",
];

/// Runs every check in order and stops at the first that fails.
pub fn run() -> Result<()> {
    cargo::run(&["fmt", "--all", "--check"], &[])?;
    for manifest in OTHER_WORKSPACES {
        cargo::run(&["fmt", "--manifest-path", manifest, "--check"], &[])?;
    }
    style::run()?;
    circles::run()?;
    architecture::run()?;
    links::run()?;
    generated::run(&[])?;
    licences::run()?;
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
    packages::run()?;
    // Lock files follow the dependencies of the crates; that of `fuzz` is not kept.
    for manifest in &OTHER_WORKSPACES[..2] {
        cargo::run(&["fetch", "--locked", "--manifest-path", manifest], &[])?;
    }
    documentation::run()?;
    readmes::run()?;
    packages::without_default_features()?;
    // The same command as in the README.
    cargo::run(&["test", "--workspace"], &[])?;
    // The features of the whole workspace are those of the build before.
    let not_run = slow::run_selection(Selection::Within(SLOW_SECONDS), None)?;
    report_not_run(&not_run)
}

/// Adds slow tests that were not run to the list that `.ci/run` prints at its end.
fn report_not_run(tests: &[String]) -> Result<()> {
    let Some(list) = std::env::var_os("CI_SKIPPED").filter(|_| !tests.is_empty()) else {
        return Ok(());
    };
    let mut list = OpenOptions::new().append(true).open(list)?;
    writeln!(
        list,
        "slow tests, which cargo xtask slow runs: {}",
        tests.join(", ")
    )?;
    Ok(())
}
