//! Table 1 of Berti et al. (2021), repeated: formulations x solvers x sizes of the three-sphere
//! scene.

mod cell;
mod paper;
mod report;

use std::path::Path;

use anyhow::{Result, bail};

pub use cell::print;
use cell::{Measured, Outcome};

const FORMULATIONS: [&str; 3] = ["p-tilde", "lagrange", "direct-row"];

/// A mesh of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Size {
    /// Approximate number of dofs.
    pub dofs: usize,
    /// Element size on the spheres that gives about this number of dofs.
    surface_size: f64,
    /// Subdomains of additive Schwarz: eight on the smallest mesh, as in the paper, and of the same
    /// size on the others.
    subdomains: usize,
    solvers: &'static [Solver],
}

/// A solver of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solver {
    Block,
    Minres,
    Direct,
    Schwarz,
}

impl Solver {
    pub fn word(self) -> &'static str {
        match self {
            Self::Block => "block",
            Self::Minres => "minres",
            Self::Direct => "direct",
            Self::Schwarz => "schwarz",
        }
    }

    /// Tolerance of the residual; PETSc's additive Schwarz, with which ours is compared, had 1e-6.
    fn rtol(self) -> f64 {
        match self {
            Self::Schwarz => 1e-6,
            _ => 1e-8,
        }
    }

    /// Number of rounds: solves that take about a second are repeated, for a median.
    fn repeats(self, repeats: usize) -> usize {
        match self {
            Self::Block => repeats,
            _ => 1,
        }
    }
}

use Solver::{Block, Direct, Minres, Schwarz};

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

/// One cell of the table.
#[derive(Clone, Copy, Debug)]
pub struct Task {
    pub size: Size,
    pub formulation: &'static str,
    pub solver: Solver,
}

impl Task {
    fn overrides(&self) -> Vec<String> {
        vec![
            format!("fem.surface_size={}", self.size.surface_size),
            format!("fem.formulation={}", self.formulation),
            format!("fem.solver={}", self.solver.word()),
            format!("fem.subdomains={}", self.size.subdomains),
            format!("fem.rtol={:e}", self.solver.rtol()),
        ]
    }
}

/// A cell with its result.
pub struct Row {
    pub task: Task,
    pub outcome: Outcome,
}

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

/// Largest relative error of the forces: the tolerance of the validation for element size 0.6, the
/// coarsest here.
const FORCE_ERROR: f64 = 5e-2;

impl Row {
    /// Whether the solution is right, or MINRES has refused the formulation that is not symmetric.
    fn is_as_expected(&self) -> bool {
        match (&self.outcome, self.task.solver, self.task.formulation) {
            (Outcome::Failed(message), Minres, "direct-row") => message.contains("symmetric"),
            (Outcome::Failed(_), ..) => false,
            (Outcome::Solved(_), Minres, "direct-row") => false,
            (Outcome::Solved(measured), ..) => {
                measured.residual <= self.task.solver.rtol() && measured.force_error <= FORCE_ERROR
            }
        }
    }
}
