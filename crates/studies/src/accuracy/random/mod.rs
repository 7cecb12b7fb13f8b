//! Errors, corrected errors and error bars of random instantaneous solutions and random strokes.

mod arrangement;
mod case;
mod instants;
mod quantity;
mod report;
mod strokes;

use std::fs::File;
use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};
use case::Case;

use crate::folder;

/// Computes the cases of successive seeds and writes `random.md` and `random.csv`.
///
/// Each line of the table of values is written as soon as it is known, so that an interrupted study
/// keeps what it has.
///
/// # Errors
/// Scenes that are invalid; files that cannot be written.
pub fn run(instants: usize, strokes: usize, seed: u64, out: &Path) -> Result<()> {
    folder::write(out, [("random.csv", Case::CSV_HEAD)])?;
    let path = out.join("random.csv");
    let mut csv = File::options().append(true).open(&path)?;
    let mut cases = Vec::new();
    let mut keep = |number: usize, of: usize, case: Case| -> Result<()> {
        csv.write_all(case.csv().as_bytes())
            .with_context(|| format!("could not write {}", path.display()))?;
        eprintln!("{} {number}/{of}: {}", case.kind, report::line(&case));
        cases.push(case);
        Ok(())
    };
    for number in 0..instants {
        let seed = seed.wrapping_add(number as u64);
        for case in instants::cases(seed).with_context(|| format!("instant of seed {seed}"))? {
            keep(number + 1, instants, case)?;
        }
    }
    for number in 0..strokes {
        let seed = seed.wrapping_add(number as u64);
        let case = strokes::case(seed).with_context(|| format!("stroke of seed {seed}"))?;
        keep(number + 1, strokes, case)?;
    }
    let text = report::markdown(&cases, seed);
    println!("{text}");
    folder::write(out, [("random.md", text)])
}
