//! Comparison with exact values: every row has a tolerance with a source.

mod axisymmetric;
mod deforming;
mod expected;
mod inertia;
mod joints;
mod multipole;
mod row;
mod shapes;
mod similar;
mod spheres;
mod summary;
mod swimmer;
mod thinning;
mod thinning_meridian;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, bail};

use crate::page;
use row::Row;

/// Name for messages, and the function that computes the rows; its argument is `quick`.
type Part = (&'static str, fn(bool) -> Result<Vec<Row>>);

/// Computes and prints all rows and writes `validation.md`, `validation.csv`, charts and
/// `index.html`; with `only`, those of the parts whose names contain it.
///
/// # Errors
/// A row that cannot be computed, or is outside its tolerance; no such part.
pub fn run(quick: bool, only: Option<&str>, out: &Path) -> Result<()> {
    let clock = Instant::now();
    let mut rows: Vec<Row> = Vec::new();
    let parts: [Part; 15] = [
        ("sphere in a concentric ball", spheres::concentric),
        ("orders of convergence", similar::orders),
        ("two spheres", spheres::pairs),
        ("collinear spheres in a ball", spheres::collinear),
        (
            "three-sphere swimmer, single configurations",
            swimmer::configurations,
        ),
        ("three-sphere swimmer, mesh file", swimmer::on_mesh_file),
        ("three-sphere swimmer, strokes", swimmer::strokes),
        ("elements in the meridian plane", axisymmetric::rows),
        ("multipole expansions", multipole::rows),
        ("hinges and springs", joints::rows),
        ("bodies of other shapes", shapes::rows),
        ("fluids with inertia", inertia::rows),
        ("fluids that thin", thinning::rows),
        ("fluids that thin, meridian plane", thinning_meridian::rows),
        ("bodies that deform", deforming::rows),
    ];
    let is_asked = |name: &str| only.is_none_or(|only| name.contains(only));
    if !parts.iter().any(|(name, _)| is_asked(name)) {
        let names = parts.map(|(name, _)| name).join("; ");
        bail!("no part of the validation contains that; the parts are: {names}");
    }
    for (name, part) in parts.into_iter().filter(|(name, _)| is_asked(name)) {
        let part_clock = Instant::now();
        let more = part(quick).with_context(|| format!("validation of: {name}"))?;
        let passed = more.iter().filter(|row| row.passes()).count();
        let seconds = part_clock.elapsed().as_secs_f64();
        eprintln!(
            "{name}: {passed} of {} rows pass, {seconds:.1} s",
            more.len()
        );
        rows.extend(more);
    }
    let failed = rows.iter().filter(|row| !row.passes()).count();
    let mut notes = summary::bar_notes(&rows);
    if only.is_none() {
        notes.insert(0, spheres::PAIR_NOTE.to_owned());
    }
    notes.push(
        format!(
            "{} of {} rows pass, {:.0} s on {} threads; the seconds of a row include all its solves and meshes, and rows of one case share them.",
            rows.len() - failed,
            rows.len(),
            clock.elapsed().as_secs_f64(),
            rayon::current_num_threads(),
        ),
    );
    summary::page(&rows, &notes).write(out, "validation")?;
    page::write(out, "validation.csv", &summary::table(&rows).csv())?;
    summary::overview(&rows, &notes)?.write_html(out, "index")?;
    eprintln!("see {}", out.join("index.html").display());
    if failed > 0 {
        bail!(
            "{failed} of {} rows are outside their tolerance",
            rows.len()
        );
    }
    Ok(())
}
