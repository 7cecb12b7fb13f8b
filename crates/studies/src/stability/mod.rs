//! The stability map: stress cases, each of which must end in the right solution or in an error
//! with a reason.

mod algebra;
mod faults;
mod flow;
mod ilu;
mod integration;
mod map;
mod models;
mod page;
mod picture;
mod report;
mod setup;
mod store;
mod stress_cases;
mod strokes;

use std::path::Path;
use std::time::Instant as Clock;

use anyhow::{Result, bail};

use integration::Study;
use map::{Map, Tried};
use store::Store;

/// Results of the study.
struct Everything {
    maps: Vec<Map>,
    algebra: Vec<Tried>,
    integrators: Study,
    seconds: f64,
}

impl Everything {
    fn run(quick: bool, store: &mut Store) -> Result<Self> {
        let clock = Clock::now();
        let integrators = integration::study(quick)?;
        Ok(Self {
            maps: vec![
                flow::map(quick, store)?,
                models::map(quick, store)?,
                strokes::map(quick, store)?,
            ],
            algebra: algebra::rows()?,
            integrators,
            seconds: clock.elapsed().as_secs_f64(),
        })
    }

    /// Tests of whole systems and of integrators.
    fn tried(&self) -> impl Iterator<Item = &Tried> {
        self.algebra.iter().chain(&self.integrators.tried)
    }

    /// Number of stress cases.
    fn stress_cases(&self) -> usize {
        self.maps.iter().map(|map| map.rows.len()).sum::<usize>() + self.tried().count()
    }

    /// Number of cells.
    fn cells(&self) -> usize {
        self.maps.iter().flat_map(Map::cells).count() + self.tried().count()
    }

    /// Number of wrong solutions without an error message.
    fn wrong(&self) -> usize {
        let cells = self.maps.iter().flat_map(Map::cells);
        cells.filter(|cell| cell.outcome.is_wrong()).count()
            + self
                .tried()
                .filter(|tried| tried.outcome.contains("WRONG"))
                .count()
    }

    /// Number of cells that are not as expected.
    fn unexpected(&self) -> usize {
        let cells = self.maps.iter().flat_map(Map::cells);
        cells.filter(|cell| !cell.as_expected).count()
            + self.tried().filter(|tried| !tried.as_expected).count()
    }
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
    let everything = Everything::run(quick, &mut store)?;
    report::write(&everything, out)?;
    store.close()?;
    let unexpected = everything.unexpected();
    if unexpected > 0 {
        bail!(
            "{unexpected} of {} cells are not as expected",
            everything.cells()
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_outcomes_of_the_quick_map_are_expected() {
        let everything = Everything::run(true, &mut Store::none()).unwrap();
        for map in &everything.maps {
            for row in &map.rows {
                for (cell, column) in row.cells.iter().zip(&map.columns) {
                    assert!(cell.as_expected, "{}, {column}: {cell:?}", row.case);
                }
            }
        }
        for tried in everything.tried() {
            assert!(tried.as_expected, "{tried:?}");
        }
        assert_eq!(everything.wrong(), 0);
        let page = page::html(&everything).unwrap();
        assert!(page.contains("<svg") && page.contains("Wrong answers"));
    }
}
