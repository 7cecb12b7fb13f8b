//! One cell of the table: one solve in a separate process, so that its peak memory can be measured.

use std::process::Command;

use anyhow::{Context, Result, bail};
use serde_json::Value;
use swimmer::choose;
use swimmer::output::solution_json;
use swimmer::solve_start;

use super::task::Task;
use crate::reference::INSTANTANEOUS;
use crate::scene_files;

/// Measurements of one solve.
#[derive(Clone, Debug)]
pub struct Measured {
    pub dofs: usize,
    pub iterations: usize,
    pub residual: f64,
    pub assembly: f64,
    pub setup: f64,
    pub solve: f64,
    pub mesh: f64,
    /// Peak resident memory in MiB, mesh generation included.
    pub memory: f64,
    /// Relative error of the velocity of the middle sphere.
    pub velocity_error: f64,
    /// Largest error of the three axial forces over the largest force.
    pub force_error: f64,
}

impl Measured {
    /// Seconds of assembly, set-up and solve, without mesh generation.
    pub fn total(&self) -> f64 {
        self.assembly + self.setup + self.solve
    }
}

/// Result of a cell.
#[derive(Clone, Debug)]
pub enum Outcome {
    Solved(Measured),
    /// Error message.
    Failed(String),
}

/// Computes a cell in a new process of this program.
pub fn run(task: &Task) -> Result<Outcome> {
    let program = std::env::current_exe().context("could not find this program's own file")?;
    let output = Command::new(program)
        .arg("table1-cell")
        .args(task.overrides())
        // The message is searched in the output, which a backtrace would make longer.
        .env_remove("RUST_BACKTRACE")
        .output()
        .context("could not start a process for a cell of the table")?;
    if !output.status.success() {
        let text = String::from_utf8_lossy(&output.stderr);
        let message = text.lines().find_map(|line| line.strip_prefix("Error: "));
        return Ok(Outcome::Failed(
            message.map_or_else(|| output.status.to_string(), str::to_owned),
        ));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let json: Value = serde_json::from_str(&text).context("a cell printed no JSON")?;
    Ok(Outcome::Solved(read(&json)?))
}

/// Solves the start of the default scene at unit rate and prints the solution as JSON.
///
/// This runs in the process of a cell.
pub fn print(overrides: &[String]) -> Result<()> {
    let mut all = scene_files::with_unit_rate(overrides);
    // The table of the paper is for the whole fluid.
    all.push("fem.symmetry=off".to_owned());
    // The table is about the solver; error estimates would add to its cost.
    all.push("fem.estimates=off".to_owned());
    let scene = scene_files::read("three-sphere.toml", &all)?;
    let mut model = choose(&scene)?.model;
    let instant = solve_start(&scene, model.as_mut())?;
    println!("{}", solution_json(&scene, model.name(), &instant));
    Ok(())
}

fn read(json: &Value) -> Result<Measured> {
    let number = |path: &str| -> Result<f64> {
        match json.pointer(path).and_then(Value::as_f64) {
            Some(number) => Ok(number),
            None => bail!("a cell's JSON has no number at {path}"),
        }
    };
    let exact = &INSTANTANEOUS[0];
    let largest = exact.forces.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    let mut force_error = 0.0_f64;
    for (body, force) in exact.forces.iter().enumerate() {
        let computed = number(&format!("/bodies/{body}/force/0"))?;
        force_error = force_error.max((computed - force).abs() / largest);
    }
    let velocity = number("/bodies/1/velocity/0")?;
    Ok(Measured {
        dofs: number("/dofs/total")? as usize,
        iterations: number("/solver/iterations")? as usize,
        residual: number("/solver/true_relative_residual")?,
        assembly: number("/seconds/assembly")?,
        setup: number("/seconds/setup")?,
        solve: number("/seconds/solve")?,
        mesh: number("/seconds/mesh")?,
        memory: number("/peak_rss_mib").unwrap_or(f64::NAN),
        velocity_error: (velocity / exact.centre_velocity - 1.0).abs(),
        force_error,
    })
}
