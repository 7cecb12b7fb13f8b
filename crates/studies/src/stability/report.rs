//! The map as Markdown and CSV, with the HTML page and pictures.

use std::fmt::Write;
use std::path::Path;

use anyhow::Result;

use super::integration::Point;
use super::map::{Map, Outcome, Tried};
use super::page;
use super::results::Results;
use crate::{folder, machine};

/// Prints the map and writes its files.
pub fn write(results: &Results, out: &Path) -> Result<()> {
    let text = markdown(results)?;
    println!("{text}");
    let (scallop, stroke) = page::charts(results)?;
    let files = [
        ("stability.md", text),
        ("stability.csv", csv(results)?),
        ("stability.html", page::html(results)?),
        ("stability-scallop.svg", scallop),
        ("stability-integrators.svg", stroke),
    ];
    folder::write(out, files)
}

/// Prints one map.
pub fn print(map: &Map) -> Result<()> {
    let mut text = String::new();
    table(&mut text, map)?;
    println!("{text}");
    Ok(())
}

fn markdown(results: &Results) -> Result<String> {
    let mut text = format!(
        "# The stability map\n\n{}, {}; {:.0} s. Made by `cargo xtask stability`; [page with pictures](stability.html).\n\n\
         {} stress cases, {} cells. *no* is an error with a reason, **WRONG** a wrong solution without an error. Wrong solutions: {}.\n",
        machine::today(),
        machine::processor(),
        results.seconds,
        results.stress_cases(),
        results.cells(),
        results.wrong()
    );
    for map in &results.maps {
        table(&mut text, map)?;
    }
    text.push_str("\n## Integrators\n\n");
    tried(&mut text, &results.integrators.tried)?;
    text.push_str("\n![scallop drift](stability-scallop.svg)\n![error of a stroke](stability-integrators.svg)\n\n");
    text.push_str(
        "Three unequal spheres on a bent chain in unbounded fluid (rpy), which rotate while they swim. Scallop drift: displacement after an arm closes and opens again, \
         exactly zero. Stroke: four phases, error of the middle sphere. Errors in radii.\n\n| integrator | choice | solves | scallop drift | stroke: solves | error |\n|:--|:--|--:|--:|--:|--:|\n",
    );
    let study = &results.integrators;
    for (scallop, stroke) in study.scallop.iter().zip(&study.stroke) {
        writeln!(
            text,
            "| {} | {} | {} | {:.1e} | {} | {:.1e} |",
            scallop.integrator,
            scallop.choice,
            scallop.solves,
            scallop.error,
            stroke.solves,
            stroke.error
        )?;
    }
    text.push_str("\n## Algebra\n\nStress cases that cannot be described by a scene, for the systems of the bent chain:\n\n");
    tried(&mut text, &results.algebra)?;
    Ok(text)
}

fn table(text: &mut String, map: &Map) -> Result<()> {
    write!(
        text,
        "\n## {}\n\n{}\n\n| stress case |",
        map.title, map.note
    )?;
    map.columns
        .iter()
        .try_for_each(|column| write!(text, " {column} |"))?;
    text.push_str("\n|:--|");
    text.push_str(&":-:|".repeat(map.columns.len()));
    text.push('\n');
    for row in &map.rows {
        write!(text, "| {} |", row.case)?;
        for cell in &row.cells {
            let mark = match &cell.outcome {
                Outcome::Refused(_) => "*no*".to_owned(),
                Outcome::Wrong { .. } => format!("**{}**", cell.outcome.mark()),
                other => other.mark(),
            };
            let unexpected = if cell.as_expected { "" } else { " (!)" };
            write!(text, " {mark}{unexpected} |")?;
        }
        text.push('\n');
    }
    text.push_str("\n(!) means that the outcome is not the expected one. Reasons of refusals:\n\n");
    for (message, case) in map.reasons() {
        writeln!(text, "- {case}: {}", message.replace('\n', " "))?;
    }
    Ok(())
}

fn tried(text: &mut String, list: &[Tried]) -> Result<()> {
    text.push_str("| test | outcome |\n|:--|:--|\n");
    for row in list {
        let unexpected = if row.as_expected { "" } else { " (!)" };
        writeln!(
            text,
            "| {} | {}{unexpected} |",
            row.name,
            row.outcome.replace('\n', " ")
        )?;
    }
    Ok(())
}

fn csv(results: &Results) -> Result<String> {
    let clean = |s: &str| s.replace(',', ";").replace(['"', '\n'], " ");
    let mut text =
        String::from("map,stress_case,method,outcome,mark,error,seconds,as_expected,message\n");
    for map in &results.maps {
        for row in &map.rows {
            for (cell, column) in row.cells.iter().zip(&map.columns) {
                let (error, message) = match &cell.outcome {
                    Outcome::Refused(message) => (String::new(), clean(message)),
                    Outcome::Right { error, .. } | Outcome::Wrong { error } => {
                        (format!("{error:e}"), String::new())
                    }
                };
                writeln!(
                    text,
                    "{},{},{column},{},{},{error},{:.3},{},{message}",
                    map.key,
                    clean(&row.case),
                    cell.outcome.word(),
                    clean(&cell.outcome.mark()),
                    cell.seconds,
                    cell.as_expected
                )?;
            }
        }
    }
    let study = &results.integrators;
    for (map, points) in [("scallop", &study.scallop), ("stroke", &study.stroke)] {
        for Point {
            integrator,
            choice,
            solves,
            error,
            ..
        } in points
        {
            writeln!(
                text,
                "{map},{},{},measured,{solves} solves,{error:e},,true,",
                clean(integrator),
                clean(choice)
            )?;
        }
    }
    Ok(text)
}
