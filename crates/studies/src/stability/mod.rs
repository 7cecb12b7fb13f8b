//! The stability map: stress cases, each of which must end in the right solution or in an error
//! with a reason.

mod algebra;
mod drives;
mod faults;
mod flow;
mod ilu;
mod inf_sup;
mod integration;
mod map;
mod models;
mod page;
mod picture;
mod report;
mod results;
mod setup;
mod store;
mod stress_cases;
mod strokes;

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::ValueEnum;

use map::Map;
use results::Results;
use store::Store;

/// A map of the study.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Part {
    /// Formulations and solvers of finite elements.
    Flow,
    /// Models.
    Models,
    /// Strokes with every mesh motion.
    Strokes,
    /// Joints, springs, loops, corners and masses.
    Drives,
}

impl Part {
    fn map(self, quick: bool, store: &mut Store) -> Result<Map> {
        match self {
            Self::Flow => flow::map(quick, store),
            Self::Models => models::map(quick, store),
            Self::Strokes => strokes::map(quick, store),
            Self::Drives => drives::map(quick, store),
        }
    }
}

/// Computes one map and prints it.
///
/// A run that was stopped continues where it was when it is started again.
///
/// # Errors
/// An outcome that is not as expected.
pub fn run_part(part: Part, quick: bool, out: &Path) -> Result<()> {
    let mut store = Store::open(out)?;
    let map = part.map(quick, &mut store)?;
    report::print(&map)?;
    store.close()?;
    let unexpected = map.cells().filter(|cell| !cell.as_expected).count();
    if unexpected > 0 {
        bail!(
            "{unexpected} of {} cells are not as expected",
            map.cells().count()
        );
    }
    Ok(())
}

/// Computes all maps and runs all tests.
fn compute(quick: bool, store: &mut Store) -> Result<Results> {
    let clock = Instant::now();
    let integrators = integration::study(quick)?;
    Ok(Results {
        maps: Part::value_variants()
            .iter()
            .map(|part| part.map(quick, store))
            .collect::<Result<_>>()?,
        algebra: algebra::rows()?,
        integrators,
        seconds: clock.elapsed().as_secs_f64(),
    })
}

/// Runs the study and writes `stability.md`, `stability.csv`, pictures and the page
/// `stability.html`.
///
/// A run that was stopped continues where it was when it is started again.
///
/// # Errors
/// An outcome that is not as expected.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let mut store = Store::open(out)?;
    let results = compute(quick, &mut store)?;
    report::write(&results, out)?;
    store.close()?;
    let unexpected = results.unexpected();
    if unexpected > 0 {
        bail!(
            "{unexpected} of {} cells are not as expected",
            results.cells()
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_outcomes_of_the_quick_map_are_expected() {
        let results = compute(true, &mut Store::none()).unwrap();
        for map in &results.maps {
            for row in &map.rows {
                for (cell, column) in row.cells.iter().zip(&map.columns) {
                    assert!(cell.as_expected, "{}, {column}: {cell:?}", row.case);
                }
            }
        }
        for tried in results.tried() {
            assert!(tried.as_expected, "{tried:?}");
        }
        assert_eq!(results.wrong(), 0);
        let page = page::html(&results).unwrap();
        assert!(page.contains("<svg") && page.contains("Wrong answers"));
    }
}
