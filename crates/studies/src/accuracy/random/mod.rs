//! Errors, corrected errors and error bars of random instantaneous solutions and random strokes.

mod arrangement;
mod case;
mod instants;
mod quantity;
mod report;
mod strokes;

use std::collections::HashSet;
use std::fs::{self, File};
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
/// Each line of the table of values is written as soon as it is known. With `resume`, cases that
/// the table in the folder has already are not computed again.
///
/// # Errors
/// Scenes that are invalid; files that cannot be written.
pub fn run(
    [instants, squirmers, strokes]: [usize; 3],
    seed: u64,
    resume: bool,
    out: &Path,
) -> Result<()> {
    let path = out.join("random.csv");
    let mut cases = match resume {
        true => case::read(
            &fs::read_to_string(&path)
                .with_context(|| format!("could not read {}", path.display()))?,
        ),
        false => Vec::new(),
    };
    let known: HashSet<(String, u64)> = (cases.iter())
        .map(|case| (case.kind.clone(), case.seed))
        .collect();
    let is_known = |kind: &str, seed: u64| known.contains(&(kind.to_owned(), seed));
    let text: String = cases.iter().map(Case::csv).collect();
    folder::write(out, [("random.csv", Case::CSV_HEAD.to_owned() + &text)])?;
    let mut csv = File::options().append(true).open(&path)?;
    let mut keep = |number: usize, of: usize, case: Case| -> Result<()> {
        csv.write_all(case.csv().as_bytes())
            .with_context(|| format!("could not write {}", path.display()))?;
        eprintln!("{} {number}/{of}: {}", case.kind, report::line(&case));
        cases.push(case);
        Ok(())
    };
    for (kind, count) in [("instant", instants), ("squirmer", squirmers)] {
        for number in 0..count {
            let seed = seed.wrapping_add(number as u64);
            if is_known(kind, seed) {
                continue;
            }
            let has_slip = kind == "squirmer";
            let cases = instants::cases(seed, has_slip);
            for case in cases.with_context(|| format!("instant of seed {seed}"))? {
                keep(number + 1, count, case)?;
            }
        }
    }
    for number in 0..strokes {
        let seed = seed.wrapping_add(number as u64);
        if is_known("stroke", seed) {
            continue;
        }
        let case = strokes::case(seed).with_context(|| format!("stroke of seed {seed}"))?;
        keep(number + 1, strokes, case)?;
    }
    let text = report::markdown(&cases, seed);
    println!("{text}");
    folder::write(out, [("random.md", text)])
}
