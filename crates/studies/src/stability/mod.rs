//! The stability map: stress cases, each of which must end in the right solution or in an error
//! with a reason.

mod algebra;
mod drives;
mod every_model;
mod faults;
mod inf_sup;
mod integrators;
mod map;
mod mesh_motions;
mod solvers;
mod stress_cases;

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::ValueEnum;

use crate::page::{self, Page};
use crate::table::{Table, count, exp};
use map::{Map, Store, Tried};

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
            Self::Flow => solvers::map(quick, store),
            Self::Models => every_model::map(quick, store),
            Self::Strokes => mesh_motions::map(quick, store),
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
    let mut page = Page::new("One map", "stability", "");
    map.add_to(&mut page);
    println!("{}", page.markdown());
    store.close()?;
    let unexpected = map.cells().filter(|cell| !cell.as_expected).count();
    refuse_unexpected(unexpected, map.cells().count())
}

fn refuse_unexpected(unexpected: usize, cells: usize) -> Result<()> {
    match unexpected {
        0 => Ok(()),
        _ => bail!("{unexpected} of {cells} cells are not as expected"),
    }
}

/// Runs the study and writes `stability.md`, `stability.csv`, charts and the page `stability.html`.
///
/// A run that was stopped continues where it was when it is started again.
///
/// # Errors
/// An outcome that is not as expected.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let mut store = Store::open(out)?;
    let results = Results::new(quick, &mut store)?;
    let page = results.page()?;
    page.write(out, "stability")?;
    page.write_html(out, "stability")?;
    page::write(out, "stability.csv", &results.values().csv())?;
    store.close()?;
    refuse_unexpected(results.unexpected(), results.cells())
}

/// Results of the study.
struct Results {
    maps: Vec<Map>,
    algebra: Vec<Tried>,
    integrators: integrators::Study,
    seconds: f64,
}

impl Results {
    /// Computes all maps and runs all tests.
    fn new(quick: bool, store: &mut Store) -> Result<Self> {
        let clock = Instant::now();
        let integrators = integrators::study(quick)?;
        let maps = Part::value_variants().iter();
        Ok(Self {
            maps: maps
                .map(|part| part.map(quick, store))
                .collect::<Result<_>>()?,
            algebra: algebra::rows()?,
            integrators,
            seconds: clock.elapsed().as_secs_f64(),
        })
    }

    /// Tests of whole systems and of integrators.
    fn tried(&self) -> impl Iterator<Item = &Tried> {
        self.algebra.iter().chain(&self.integrators.tried)
    }

    fn stress_cases(&self) -> usize {
        self.maps.iter().map(|map| map.rows.len()).sum::<usize>() + self.tried().count()
    }

    fn cells(&self) -> usize {
        self.maps.iter().flat_map(Map::cells).count() + self.tried().count()
    }

    /// Number of cells of the maps with this outcome.
    fn with_outcome(&self, word: &str) -> usize {
        let cells = self.maps.iter().flat_map(Map::cells);
        cells.filter(|cell| cell.outcome.word() == word).count()
    }

    /// Number of wrong solutions without an error message.
    fn wrong(&self) -> usize {
        let tried = self.tried().filter(|tried| tried.outcome.contains("WRONG"));
        self.with_outcome("wrong") + tried.count()
    }

    /// Number of cells that are not as expected.
    fn unexpected(&self) -> usize {
        let cells = self.maps.iter().flat_map(Map::cells);
        cells.filter(|cell| !cell.as_expected).count()
            + self.tried().filter(|tried| !tried.as_expected).count()
    }

    fn page(&self) -> Result<Page> {
        let text = format!(
            "{:.0} s; [page with pictures](stability.html).\n\n\
             {} stress cases, {} cells: every stress case is computed with every method, and each must end in the right solution \
             or in an error with a reason. *no* is an error with a reason, **WRONG** a wrong solution without an error. Wrong solutions: {}.",
            self.seconds,
            self.stress_cases(),
            self.cells(),
            self.wrong()
        );
        let mut page = Page::new("The stability map", "stability", text);
        page.figures([
            (self.stress_cases().to_string(), "stress cases"),
            (self.cells().to_string(), "cells"),
            (
                self.with_outcome("right").to_string(),
                "right, of the maps' cells",
            ),
            (
                self.with_outcome("refused").to_string(),
                "refused with a reason",
            ),
            (self.wrong().to_string(), "Wrong answers"),
        ]);
        self.maps.iter().for_each(|map| map.add_to(&mut page));
        self.integrators.add_to(&mut page)?;
        page.heading("Algebra");
        page.text(
            "Stress cases that cannot be described by a scene, for the systems of the bent chain:",
        );
        page.table(Tried::table(&self.algebra));
        Ok(page)
    }

    /// One row per cell of the maps and per run of an integrator.
    fn values(&self) -> Table {
        let mut table = Table::new([
            "map",
            "stress_case",
            "method",
            "outcome",
            "mark",
            "error",
            "seconds",
            "as_expected",
            "message",
        ]);
        self.maps.iter().for_each(|map| map.add_values(&mut table));
        let study = &self.integrators;
        for (map, points) in [("scallop", &study.scallop), ("stroke", &study.stroke)] {
            for point in points {
                table.push([
                    map.into(),
                    point.integrator.into(),
                    point.choice.as_str().into(),
                    "measured".into(),
                    count(point.solves).shown(format!("{} solves", point.solves)),
                    exp(point.error, 1),
                ]);
            }
        }
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_outcomes_of_the_quick_map_are_expected() {
        let results = Results::new(true, &mut Store::none()).unwrap();
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
        let page = results.page().unwrap().html();
        assert!(page.contains("<svg") && page.contains("Wrong answers"));
        let values = results.values().csv();
        assert!(values.lines().count() > results.maps.iter().flat_map(Map::cells).count());
    }
}
