//! Project tasks: `cargo xtask ci` and its checks one by one.
//!
//! Every other task is a study of `crates/studies`.
//!
//! This crate depends on no solver, so that `cargo xtask ci` starts with the format check instead
//! of the build of METIS and faer.
#![forbid(unsafe_code)]

mod architecture;
mod cargo;
mod ci;
mod circles;
mod documentation;
mod files;
mod generated;
mod licences;
mod links;
mod manifests;
mod modules;
mod packages;
mod pages;
mod readmes;
mod slow;
mod style;

use std::fmt::Display;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};

const HELP: &str = "\
Project tasks

Usage: cargo xtask <TASK> [OPTIONS]

Tasks of this program:
  ci        All checks of CI: format, style, circles, ARCHITECTURE.md, links, ages of
            generated pages, lints, documentation, licences, packages, programs of READMEs, tests
  circles   Circles of files that use each other, in each crate
  documentation
            The pages of rustdoc, in the order that lets crates link to each other
  generated Pages that are older than their generators; with the names of pages: these were
            made again
  licences  Licences of the default dependency graph; GPL and AGPL are refused
  links     Links of the documentation: files, headings, files that a page names
  readmes   The programs of the crates' READMEs, built with the dependencies that they state
  slow      Tests that are ignored because they are slow, one by one with their times, and
            docs/slow-tests.md; --below SECONDS: only those with such a stated time;
            --package NAME: only those of one package
  style     Rules of style: widths of comments, names of folders, times of slow tests

All other tasks are studies, built with optimisation when first used:
";

fn main() -> Result<ExitCode> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match words[..] {
        ["ci"] => ci::run(),
        ["circles"] => circles::run(),
        ["documentation"] => documentation::run(),
        ["generated", ..] => generated::run(&words[1..]),
        ["licences"] => licences::run(),
        ["links"] => links::run(),
        ["readmes"] => readmes::run(),
        ["slow", ..] => slow::run(&arguments[1..]),
        ["style"] => style::run(),
        [] | ["help" | "--help" | "-h", ..] => {
            println!("{HELP}");
            return study(&["--help".to_owned()]);
        }
        _ => return study(&arguments),
    }
    .map(|()| ExitCode::SUCCESS)
}

/// Runs a study in its own process and returns the exit code of that process.
fn study(arguments: &[String]) -> Result<ExitCode> {
    let status = cargo::command(&["run", "--release", "--quiet"])
        .args(["--package", "microswim-studies", "--bin", "studies", "--"])
        .args(arguments)
        .status()
        .context("could not start cargo run")?;
    // Exit codes above 255, and processes ended by a signal, count as plain failures.
    let code = status.code().and_then(|code| u8::try_from(code).ok());
    Ok(code.map_or(ExitCode::FAILURE, ExitCode::from))
}

/// Lists what a check found, and fails if that is anything; `what` follows its number.
fn expect_none(found: &[impl Display], what: &str) -> Result<()> {
    for problem in found {
        eprintln!("{problem}");
    }
    match found.len() {
        0 => Ok(()),
        count => bail!("{count} {what}"),
    }
}
