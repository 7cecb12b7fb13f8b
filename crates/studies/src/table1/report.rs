//! The table as Markdown, CSV and a chart.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;

use super::cell::{Measured, Outcome};
use super::paper::{PAPER, PETSC, REPORTED};
use super::row::Row;
use super::task::{FORMULATIONS, Solver};
use crate::chart::{LogLog, Series, Style};
use crate::{folder, machine};

/// Prints the table and writes its files.
pub fn write(rows: &[Row], out: &Path) -> Result<()> {
    let text = markdown(rows)?;
    println!("{text}");
    let files = [
        ("table1.md", text),
        ("table1.csv", csv(rows)?),
        ("table1.svg", chart(rows).svg()?),
    ];
    folder::write(out, files)
}

fn markdown(rows: &[Row]) -> Result<String> {
    let mut text = format!(
        "# Table 1, repeated\n\n\
         The start of `scenes/three-sphere.toml` at unit rate, on curved elements. {}, {}. Made by `cargo xtask table1`.\n\n\
         Every cell is a separate process; times of `block` are medians of rounds that alternate between the formulations. Iterations are to a *true* \
         residual of 1e-8 of the right-hand side (`schwarz`: 1e-6). Seconds are wall-clock times without mesh generation; memory is the peak of \
         the process, mesh generation included. Errors are against the exact solution: the relative error of the velocity of the middle sphere, and the \
         largest error of the three forces over the largest force.\n\n",
        machine::today(),
        machine::processor(),
    );
    text.push_str("| dofs | formulation | solver | iterations | assembly s | set-up s | solve s | total s | mesh s | peak MB | kB/dof | error of U | error of forces |\n");
    text.push_str("|--:|:--|:--|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    for row in rows {
        let (formulation, solver) = (row.task.formulation, label(row));
        match &row.outcome {
            Outcome::Solved(m) => writeln!(
                text,
                "| {} | {formulation} | {solver} | {} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} | {:.0} | {:.2} | {:.1e} | {:.1e} |",
                m.dofs,
                m.iterations,
                m.assembly,
                m.setup,
                m.solve,
                m.total(),
                m.mesh,
                megabytes(m),
                1e3 * megabytes(m) / m.dofs as f64,
                m.velocity_error,
                m.force_error
            )?,
            Outcome::Failed(message) => writeln!(
                text,
                "| {} | {formulation} | {solver} | refused: {message} ||||||||||",
                row.task.size.dofs
            )?,
        }
    }
    text.push_str("\nNot run: `direct` on the second and third mesh and `schwarz` on the third, whose factors would not fit into the memory of the machine.\n");
    text.push_str("\nDifference from p-tilde on the same mesh, with `block`:\n\n| dofs | formulation | iterations | total time |\n|--:|:--|--:|--:|\n");
    for (base, other) in pairs(rows) {
        writeln!(
            text,
            "| {} | {} | {:+.0} % | {:+.0} % |",
            base.dofs,
            other.0,
            100.0 * (other.1.iterations as f64 / base.iterations as f64 - 1.0),
            100.0 * (other.1.total() / base.total() - 1.0)
        )?;
    }
    text.push_str("\nReported by others for this problem (their meshes have straight elements; times of the paper are of one time step):\n\n");
    text.push_str(
        "| dofs | who | formulation | solver | iterations | total s |\n|--:|:--|:--|:--|--:|--:|\n",
    );
    for r in &REPORTED {
        let iterations = r
            .iterations
            .map_or("-".to_owned(), |count| count.to_string());
        let seconds = r
            .seconds
            .map_or("failed".to_owned(), |seconds| format!("{seconds}"));
        writeln!(
            text,
            "| {} | {} | {} | {} | {iterations} | {seconds} |",
            r.dofs, r.source, r.formulation, r.solver
        )?;
    }
    text.push_str("\n![seconds over dofs](table1.svg)\n");
    Ok(text)
}

/// Peak memory in MB, converted from MiB.
fn megabytes(measured: &Measured) -> f64 {
    measured.memory * 1.048_576
}

fn label(row: &Row) -> String {
    match row.task.solver {
        Solver::Schwarz => format!("schwarz, {} subdomains", row.task.size.subdomains),
        solver => solver.word().to_owned(),
    }
}

/// Pairs of p-tilde and another formulation, with `block` on the same mesh.
fn pairs(rows: &[Row]) -> Vec<(&Measured, (&'static str, &Measured))> {
    let block = |row: &&Row| row.task.solver == Solver::Block;
    let mut pairs = Vec::new();
    for base in rows
        .iter()
        .filter(block)
        .filter(|row| row.task.formulation == FORMULATIONS[0])
    {
        let others = rows.iter().filter(block).filter(|row| {
            row.task.size == base.task.size && row.task.formulation != FORMULATIONS[0]
        });
        for other in others {
            if let (Outcome::Solved(a), Outcome::Solved(b)) = (&base.outcome, &other.outcome) {
                pairs.push((a, (other.task.formulation, b)));
            }
        }
    }
    pairs
}

fn csv(rows: &[Row]) -> Result<String> {
    let mut text = String::from(
        "dofs,formulation,solver,subdomains,iterations,true_relative_residual,assembly_s,setup_s,solve_s,total_s,mesh_s,peak_mb,velocity_error,force_error,failure\n",
    );
    for row in rows {
        let (formulation, solver) = (row.task.formulation, row.task.solver.word());
        let subdomains = match row.task.solver {
            Solver::Schwarz => row.task.size.subdomains.to_string(),
            _ => String::new(),
        };
        match &row.outcome {
            Outcome::Solved(m) => writeln!(
                text,
                "{},{formulation},{solver},{subdomains},{},{:e},{:.4},{:.4},{:.4},{:.4},{:.4},{:.1},{:e},{:e},",
                m.dofs,
                m.iterations,
                m.residual,
                m.assembly,
                m.setup,
                m.solve,
                m.total(),
                m.mesh,
                megabytes(m),
                m.velocity_error,
                m.force_error
            )?,
            Outcome::Failed(message) => writeln!(
                text,
                "{},{formulation},{solver},{subdomains},,,,,,,,,,,\"{}\"",
                row.task.size.dofs,
                message.replace('"', "'")
            )?,
        }
    }
    Ok(text)
}

fn chart(rows: &[Row]) -> LogLog {
    let ours = |formulation: &str, solver: Solver| -> Vec<(f64, f64)> {
        rows.iter()
            .filter(|row| row.task.formulation == formulation && row.task.solver == solver)
            .filter_map(|row| match &row.outcome {
                Outcome::Solved(m) => Some((m.dofs as f64, m.total())),
                Outcome::Failed(_) => None,
            })
            .collect()
    };
    let theirs = |source: &str, formulation: &str, solver: &str| -> Vec<(f64, f64)> {
        REPORTED
            .iter()
            .filter(|r| r.source == source && r.formulation == formulation && r.solver == solver)
            .filter_map(|r| Some((r.dofs as f64, r.seconds?)))
            .collect()
    };
    let block = ours(FORMULATIONS[0], Solver::Block);
    // Slope 1 through the first point of the block solver.
    let guide = block.first().map_or_else(Vec::new, |&(dofs, seconds)| {
        let end = block.last().map_or(dofs, |last| last.0).max(2.1e6);
        vec![(dofs, seconds), (end, seconds * end / dofs)]
    });
    let curve = |name: &str, points| Series {
        name: name.to_owned(),
        points,
        style: Style::Curve,
    };
    LogLog {
        title: "three spheres, one instantaneous solution, without mesh generation".into(),
        x: "dofs".into(),
        y: "seconds".into(),
        series: vec![
            curve("block, p-tilde", block),
            curve("block, lagrange", ours(FORMULATIONS[1], Solver::Block)),
            curve("block, direct-row", ours(FORMULATIONS[2], Solver::Block)),
            curve("minres, p-tilde", ours(FORMULATIONS[0], Solver::Minres)),
            curve("schwarz, p-tilde", ours(FORMULATIONS[0], Solver::Schwarz)),
            curve("direct, p-tilde", ours(FORMULATIONS[0], Solver::Direct)),
            curve(
                "the paper on 8 cores, p-tilde, fieldsplit",
                theirs(PAPER, "p-tilde", "fieldsplit"),
            ),
            curve(PETSC, theirs(PETSC, "p-tilde", "p-multigrid")),
            Series {
                name: "slope 1".into(),
                points: guide,
                style: Style::Guide,
            },
        ],
    }
}
