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
/// The counts are those of instantaneous solutions of rigid bodies, of bodies with slip, and of
/// strokes.
///
/// Each line of the table of values is written as soon as it is known, so that an interrupted study
/// keeps what it has.
///
/// # Errors
/// Scenes that are invalid; files that cannot be written.
pub fn run([instants, squirmers, strokes]: [usize; 3], seed: u64, out: &Path) -> Result<()> {
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
    for (count, has_slip) in [(instants, false), (squirmers, true)] {
        for number in 0..count {
            let seed = seed.wrapping_add(number as u64);
            let cases = instants::cases(seed, has_slip);
            for case in cases.with_context(|| format!("instant of seed {seed}"))? {
                keep(number + 1, count, case)?;
            }
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
