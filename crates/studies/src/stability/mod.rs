//! The stability map: stress cases, each of which must end in the right solution or in an error
//! with a reason.

mod algebra;
mod drives;
mod every_model;
mod faults;
mod inf_sup;
mod integrators;
mod laws;
mod map;
mod mesh_motions;
mod solvers;
mod steady_states;
mod stress_cases;
mod time_runs;

use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail};
use clap::ValueEnum;

use crate::page::{self, Page};
use crate::table::{Table, count, exp};
use map::{Cell, Map, Store};

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
    /// Steady states with inertia.
    Steady,
    /// Runs in time with inertia.
    Time,
    /// Fluids with a viscosity law.
    Laws,
}

impl Part {
    fn map(self, quick: bool, store: &mut Store) -> Result<Map> {
        match self {
            Self::Flow => solvers::map(quick, store),
            Self::Models => every_model::map(quick, store),
            Self::Strokes => mesh_motions::map(quick, store),
            Self::Drives => drives::map(quick, store),
            Self::Steady => steady_states::map(quick, store),
            Self::Time => time_runs::map(quick, store),
            Self::Laws => laws::map(quick, store),
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
    refuse_unexpected(map.cells())
}

fn refuse_unexpected<'a>(cells: impl Iterator<Item = &'a Cell>) -> Result<()> {
    match cells.filter(|cell| !cell.as_expected).count() {
        0 => Ok(()),
        count => bail!("{count} cells are not as expected"),
    }
}

/// Runs the study and writes `stability.md`, `stability.csv`, charts and the page `stability.html`.
///
/// A run that was stopped continues where it was when it is started again. With `keep` the rows of
/// the last `stability.csv` stay, and missing ones are computed.
///
/// # Errors
/// An outcome that is not as expected; with `keep`, a table that cannot be read.
pub fn run(quick: bool, keep: bool, out: &Path) -> Result<()> {
    let mut store = Store::open(out)?;
    if keep {
        store.keep(out)?;
    }
    let results = Results::new(quick, &mut store)?;
    let page = results.page()?;
    page.write(out, "stability")?;
    page.write_html(out, "stability")?;
    page::write(out, "stability.csv", &results.values().csv())?;
    store.close()?;
    refuse_unexpected(results.cells())
}

/// Results of the study.
struct Results {
    maps: Vec<Map>,
    integrators: integrators::Study,
    /// Number of rows of earlier runs.
    known: usize,
    seconds: f64,
}

impl Results {
    /// Computes all maps and runs all tests.
    fn new(quick: bool, store: &mut Store) -> Result<Self> {
        let clock = Instant::now();
        let integrators = integrators::study(quick)?;
        let maps = Part::value_variants().iter();
        let maps = maps.map(|part| part.map(quick, store));
        let maps = maps.chain([algebra::map()]).collect::<Result<_>>()?;
        Ok(Self {
            maps,
            integrators,
            known: store.known,
            seconds: clock.elapsed().as_secs_f64(),
        })
    }

    fn maps(&self) -> impl Iterator<Item = &Map> {
        self.maps.iter().chain([&self.integrators.map])
    }

    fn cells(&self) -> impl Iterator<Item = &Cell> {
        self.maps().flat_map(Map::cells)
    }

    /// Number of cells with this outcome.
    fn with_outcome(&self, word: &str) -> usize {
        self.cells()
            .filter(|cell| cell.outcome.word() == word)
            .count()
    }

    fn page(&self) -> Result<Page> {
        let stress_cases = self.maps().map(|map| map.rows.len()).sum::<usize>();
        let (cells, wrong) = (self.cells().count(), self.with_outcome("wrong"));
        let of_before = match self.known {
            0 => String::new(),
            known => format!(" for all but {known} stress cases, which are those of earlier runs"),
        };
        let text = format!(
            "{:.0} s{of_before}; [page with pictures](stability.html).\n\n\
             {stress_cases} stress cases, {cells} cells: every stress case is computed with every method, and each must end in the right solution \
             or in an error with a reason. *no* is an error with a reason, **WRONG** a wrong solution without an error. Wrong solutions: {wrong}.",
            self.seconds,
        );
        let mut page = Page::new("The stability map", "stability", text);
        page.figures([
            (stress_cases.to_string(), "stress cases"),
            (cells.to_string(), "cells"),
            (self.with_outcome("right").to_string(), "right"),
            (
                self.with_outcome("refused").to_string(),
                "refused with a reason",
            ),
            (wrong.to_string(), "Wrong answers"),
        ]);
        self.maps.iter().for_each(|map| map.add_to(&mut page));
        self.integrators.add_to(&mut page)?;
        Ok(page)
    }

    /// One row per cell of the maps and per run of an integrator.
    fn values(&self) -> Table {
        let headings = "map stress_case method outcome mark error seconds as_expected message";
        let mut table = Table::new(headings.split(' '));
        self.maps().for_each(|map| map.add_values(&mut table));
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
        let results = Results::new(true, &mut Store::default()).unwrap();
        for map in results.maps() {
            for row in &map.rows {
                for (cell, column) in row.cells.iter().zip(&map.columns) {
                    assert!(cell.as_expected, "{}, {column}: {cell:?}", row.case);
                }
            }
        }
        assert_eq!(results.with_outcome("wrong"), 0);
        let page = results.page().unwrap().html();
        assert!(page.contains("<svg") && page.contains("Wrong answers"));
        let values = results.values().csv();
        assert!(values.lines().count() > results.cells().count());
    }
}
