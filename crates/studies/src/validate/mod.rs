//! Comparison with exact values: every row has a tolerance with a source.

mod axisymmetric;
mod bars;
mod collinear;
mod effort;
mod estimated;
mod expected;
mod file;
mod flow;
mod joints;
mod multipole;
mod overview;
mod pair;
mod row;
mod shapes;
mod similar;
mod sphere;
mod swimmer;
mod table;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::{folder, machine};
pub use effort::Effort;
use row::Row;

/// Name for messages, and the function that computes the rows.
type Part<'a> = (&'a str, &'a dyn Fn() -> Result<Vec<Row>>);

/// Computes and prints all rows and writes `validation.md`, `validation.csv`, charts and
/// `index.html`; with `only`, those of the parts whose names contain it.
///
/// # Errors
/// A row that cannot be computed, or is outside its tolerance; no such part.
pub fn run(effort: Effort, only: Option<&str>, out: &Path) -> Result<()> {
    let clock = Instant::now();
    let mut rows: Vec<Row> = Vec::new();
    let parts: [Part; 11] = [
        ("sphere in a concentric ball", &|| sphere::rows(effort)),
        ("orders of convergence", &sphere::orders),
        ("two spheres", &|| pair::rows(effort)),
        ("collinear spheres in a ball", &|| collinear::rows(effort)),
        ("three-sphere swimmer, single configurations", &|| {
            swimmer::configurations(effort)
        }),
        ("three-sphere swimmer, mesh file", &file::rows),
        ("three-sphere swimmer, strokes", &|| {
            swimmer::strokes(effort)
        }),
        ("elements in the meridian plane", &|| {
            axisymmetric::rows(effort)
        }),
        ("multipole expansions", &multipole::rows),
        ("hinges and springs", &|| joints::rows(effort)),
        ("bodies of other shapes", &|| shapes::rows(effort)),
    ];
    let is_asked = |name: &str| only.is_none_or(|only| name.contains(only));
    if !parts.iter().any(|(name, _)| is_asked(name)) {
        let names = parts.map(|(name, _)| name).join("; ");
        bail!("no part of the validation contains that; the parts are: {names}");
    }
    for (name, part) in parts.into_iter().filter(|(name, _)| is_asked(name)) {
        let part_clock = Instant::now();
        let more = part().with_context(|| format!("validation of: {name}"))?;
        let passed = more.iter().filter(|row| row.passes()).count();
        eprintln!(
            "{name}: {passed} of {} rows pass, {:.1} s",
            more.len(),
            part_clock.elapsed().as_secs_f64()
        );
        rows.extend(more);
    }
    let failed = rows.iter().filter(|row| !row.passes()).count();
    let mut notes = Vec::new();
    if only.is_none() {
        notes.push(pair::NOTE.to_owned());
    }
    notes.extend(bars::notes(&rows));
    notes.push(
        format!(
            "{} of {} rows pass, {:.0} s on {} threads; the seconds of a row include all its solves and meshes, and rows of one case share them.",
            rows.len() - failed,
            rows.len(),
            clock.elapsed().as_secs_f64(),
            rayon::current_num_threads(),
        ),
    );
    let text = table::markdown(&rows, &notes);
    println!("{text}");
    let files = [
        ("validation.md", page_of(&text)),
        ("validation.csv", table::csv(&rows)),
    ];
    folder::write(out, files)?;
    let quantities = match (effort, only) {
        (Effort::Full, None) => crate::accuracy::run(false, None, out)?,
        _ => Vec::new(),
    };
    let (page, chart) = overview::page(&rows, &notes, &quantities)?;
    folder::write(out, [("errors.svg", chart), ("index.html", page)])?;
    eprintln!("see {}", out.join("index.html").display());
    if failed > 0 {
        bail!(
            "{failed} of {} rows are outside their tolerance",
            rows.len()
        );
    }
    Ok(())
}

/// The table under a heading with machine and date.
fn page_of(table: &str) -> String {
    format!(
        "# Validation\n\n{}, {}. Made by `cargo xtask validate`.\n\n{table}",
        machine::today(),
        machine::processor(),
    )
}
