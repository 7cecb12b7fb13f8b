//! The map as Markdown and CSV.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result};

use super::algebra::Row;
use super::{Cell, FORMULATIONS, Outcome, SOLVERS};
use crate::machine;

/// Prints the map and writes its files.
pub fn write(cells: &[Cell], algebra: &[Row], seconds: f64, out: &Path) -> Result<()> {
    let text = markdown(cells, algebra, seconds)?;
    println!("{text}");
    std::fs::create_dir_all(out)
        .with_context(|| format!("could not make the folder {}", out.display()))?;
    for (name, content) in [("stability.md", text), ("stability.csv", csv(cells)?)] {
        let path = out.join(name);
        std::fs::write(&path, content).with_context(|| {
            format!(
                "could not write {}; choose another folder with --out",
                path.display()
            )
        })?;
    }
    Ok(())
}

fn markdown(cells: &[Cell], algebra: &[Row], seconds: f64) -> Result<String> {
    let wrong = cells
        .iter()
        .filter(|cell| matches!(cell.outcome, Outcome::Wrong { .. }))
        .count();
    let mut text = format!(
        "# The stability map\n\n{}, {}; {seconds:.0} s. Made by `cargo xtask stability`.\n\n\
         Each cell is a scene solved by one formulation with one solver: a number is the right answer in so many iterations (velocities \
         against an independent solve, to 1e-7 for Krylov solvers stopped at a true residual of 1e-10, to 1e-9 for the direct one), *no* is a refusal, **WRONG** \
         an answer that claims to be right and is not. Wrong answers: {wrong} of {} cells.\n\n",
        machine::today(),
        machine::processor(),
        cells.len(),
    );
    let short = ["P~", "L", "DR"];
    text.push_str("| hardship |");
    for solver in SOLVERS {
        for name in short {
            write!(text, " {solver} {name} |")?;
        }
    }
    text.push_str("\n|:--|");
    text.push_str(&":-:|".repeat(SOLVERS.len() * FORMULATIONS.len()));
    text.push('\n');
    let mut reasons: Vec<(String, &str)> = Vec::new();
    for row in cells.chunks(SOLVERS.len() * FORMULATIONS.len()) {
        write!(text, "| {} |", row[0].hardship)?;
        for cell in row {
            let mark = match &cell.outcome {
                Outcome::Right { iterations, .. } => iterations.to_string(),
                Outcome::Refused(message) => {
                    if !reasons.iter().any(|(known, _)| known == message) {
                        reasons.push((message.clone(), cell.hardship));
                    }
                    "*no*".to_owned()
                }
                Outcome::Wrong { error } => format!("**WRONG** {error:.0e}"),
            };
            let surprise = if cell.as_expected { "" } else { " (!)" };
            write!(text, " {mark}{surprise} |")?;
        }
        text.push('\n');
    }
    text.push_str("\nP~: elimination; L: Lagrange multipliers; DR: direct rows. (!) is not what was expected.\n\nReasons given:\n\n");
    for (message, hardship) in reasons {
        writeln!(text, "- {hardship}: {}", message.replace('\n', " "))?;
    }
    text.push_str("\n## Algebra\n\nWays to fail that a scene cannot ask for, tried on the systems of the bent chain:\n\n| tried | came to |\n|:--|:--|\n");
    for row in algebra {
        let surprise = if row.as_expected { "" } else { " (!)" };
        writeln!(
            text,
            "| {} | {}{surprise} |",
            row.name,
            row.outcome.replace('\n', " ")
        )?;
    }
    Ok(text)
}

fn csv(cells: &[Cell]) -> Result<String> {
    let mut text = String::from(
        "hardship,formulation,solver,outcome,iterations,error,seconds,as_expected,message\n",
    );
    for cell in cells {
        let (outcome, iterations, error, message) = match &cell.outcome {
            Outcome::Right { error, iterations } => (
                "right",
                iterations.to_string(),
                format!("{error:e}"),
                String::new(),
            ),
            Outcome::Refused(message) => (
                "refused",
                String::new(),
                String::new(),
                message.replace(['"', '\n'], " "),
            ),
            Outcome::Wrong { error } => {
                ("wrong", String::new(), format!("{error:e}"), String::new())
            }
        };
        writeln!(
            text,
            "{},{},{},{outcome},{iterations},{error},{:.3},{},\"{message}\"",
            cell.hardship.replace(',', ";"),
            cell.formulation,
            cell.solver,
            cell.seconds,
            cell.as_expected
        )?;
    }
    Ok(text)
}
