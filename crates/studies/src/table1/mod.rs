//! Table 1 of Berti et al. (2021), repeated: formulations x solvers x sizes of the three-sphere
//! scene.

mod cell;
mod paper;
mod report;
mod row;
mod task;

use std::path::Path;

use anyhow::{Result, bail};

pub use cell::print;
use cell::{Measured, Outcome};
use row::Row;
use task::Solver::{self, Block, Direct, Minres, Schwarz};
use task::{FORMULATIONS, Size, Task};

/// The sizes of the paper.
///
/// Solvers are left out where they might exceed the 24 GB of the machine: a factorisation of the
/// second mesh is estimated at 14 GB, and that of 56 subdomains of the third at 20 GB.
const FULL: [Size; 3] = [
    Size {
        dofs: 311_000,
        surface_size: 0.2033,
        subdomains: 8,
        solvers: &[Block, Minres, Direct, Schwarz],
    },
    Size {
        dofs: 888_000,
        surface_size: 0.144,
        subdomains: 24,
        solvers: &[Block, Minres, Schwarz],
    },
    Size {
        dofs: 2_094_000,
        surface_size: 0.1087,
        subdomains: 56,
        solvers: &[Block, Minres],
    },
];

/// A minute on two cores.
const QUICK: [Size; 1] = [Size {
    dofs: 50_000,
    surface_size: 0.6,
    subdomains: 8,
    solvers: &[Block, Minres, Direct, Schwarz],
}];

/// Options of the study.
pub struct Options<'a> {
    pub quick: bool,
    /// Number of mesh sizes, from the smallest on.
    pub sizes: usize,
    pub repeats: usize,
    pub out: &'a Path,
}

/// Measures all cells, prints the table and writes `table1.md`, `table1.csv` and `table1.svg` into
/// a folder.
pub fn run(options: &Options) -> Result<()> {
    let sizes: &[Size] = if options.quick { &QUICK } else { &FULL };
    let mut rows = Vec::new();
    // The slowest solvers first: load on the machine at the start affects the others less.
    for solver in [Schwarz, Minres, Block, Direct] {
        for &size in sizes.iter().take(options.sizes) {
            if size.solvers.contains(&solver) {
                rows.extend(measure(size, solver, solver.repeats(options.repeats))?);
            }
        }
    }
    let order = [Block, Minres, Direct, Schwarz];
    rows.sort_by_key(|row| {
        let place = order.iter().position(|solver| *solver == row.task.solver);
        (row.task.size.dofs, place)
    });
    report::write(&rows, options.out)?;
    let wrong: Vec<&Row> = rows.iter().filter(|row| !row.is_as_expected()).collect();
    if let Some(row) = wrong.first() {
        bail!(
            "{} of {} cells are not as expected, the first is {} with {} at {} dofs",
            wrong.len(),
            rows.len(),
            row.task.formulation,
            row.task.solver.word(),
            row.task.size.dofs
        );
    }
    Ok(())
}

/// All formulations with one solver on one mesh.
///
/// Rounds alternate between the formulations, so that other load on the machine affects all alike.
fn measure(size: Size, solver: Solver, repeats: usize) -> Result<Vec<Row>> {
    let tasks = FORMULATIONS.map(|formulation| Task {
        size,
        formulation,
        solver,
    });
    let mut outcomes: [Vec<Outcome>; 3] = Default::default();
    for round in 0..repeats {
        for (task, outcomes) in tasks.iter().zip(&mut outcomes) {
            let outcome = cell::run(task)?;
            eprintln!(
                "{} dofs, {}, {}, round {}: {}",
                size.dofs,
                task.formulation,
                solver.word(),
                round + 1,
                match &outcome {
                    Outcome::Solved(m) =>
                        format!("{} iterations, {:.2} s", m.iterations, m.total()),
                    Outcome::Failed(message) => message.clone(),
                }
            );
            outcomes.push(outcome);
        }
    }
    Ok(tasks
        .into_iter()
        .zip(outcomes)
        .map(|(task, outcomes)| Row {
            task,
            outcome: middle(outcomes),
        })
        .collect())
}

/// The round of median total time, or the first failure.
fn middle(outcomes: Vec<Outcome>) -> Outcome {
    let mut solved: Vec<Measured> = Vec::new();
    for outcome in outcomes {
        match outcome {
            Outcome::Solved(measured) => solved.push(measured),
            failed => return failed,
        }
    }
    solved.sort_by(|a, b| a.total().total_cmp(&b.total()));
    let half = solved.len() / 2;
    match solved.into_iter().nth(half) {
        Some(measured) => Outcome::Solved(measured),
        None => Outcome::Failed("not run".to_owned()),
    }
}
