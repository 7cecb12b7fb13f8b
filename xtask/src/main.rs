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
mod files;
mod licences;
mod links;
mod manifests;
mod modules;
mod packages;
mod style;

use std::process::ExitCode;

use anyhow::{Context, Result};

const HELP: &str = "\
Project tasks

Usage: cargo xtask <TASK> [OPTIONS]

Tasks of this program:
  ci        All checks of CI: format, style, circles, ARCHITECTURE.md, links, lints,
            documentation, licences, packages, tests
  circles   Circles of files that use each other, in each crate
  links     Links of the documentation: files, headings, files of the code
  licences  Licences of the default dependency graph; GPL and AGPL are refused

All other tasks are studies, built with optimisation when first used:
";

fn main() -> Result<ExitCode> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.first().map(String::as_str) {
        Some("links") if arguments.len() == 1 => links::run().map(|()| ExitCode::SUCCESS),
        Some("circles") if arguments.len() == 1 => circles::run().map(|()| ExitCode::SUCCESS),
        Some("ci") if arguments.len() == 1 => ci::run().map(|()| ExitCode::SUCCESS),
        Some("licences") if arguments.len() == 1 => licences::run().map(|()| ExitCode::SUCCESS),
        None | Some("help" | "--help" | "-h") => {
            println!("{HELP}");
            study(&["--help".to_owned()])
        }
        Some(_) => study(&arguments),
    }
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
