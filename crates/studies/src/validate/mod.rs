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
/// `index.html`.
///
/// # Errors
/// A row that cannot be computed, or is outside its tolerance.
pub fn run(effort: Effort, out: &Path) -> Result<()> {
    let clock = Instant::now();
    let mut rows: Vec<Row> = Vec::new();
    let parts: [Part; 10] = [
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
    ];
    for (name, part) in parts {
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
    let mut notes = vec![pair::NOTE.to_owned()];
    notes.extend(file::note());
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
    let quantities = match effort {
        Effort::Quick => Vec::new(),
        Effort::Full => crate::accuracy::run(false, None, out)?,
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
