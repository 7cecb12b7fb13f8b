//! Outcomes of cells, maps as tables and pictures of cells, and their store between runs.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use swimmer::SwimError;

use crate::page::{self, Page};
use crate::table::{Cell as Field, Table, exp, fixed};

/// Outcome of one method for one stress case.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum Outcome {
    /// The right solution: its error, and the text of the cell.
    Right { error: f64, mark: String },
    /// Refused with this message.
    Refused(String),
    /// A solution that is wrong, without an error message: its error, and the text of the cell.
    Wrong { error: f64, mark: String },
}

/// Outcome that a cell must have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// The right solution.
    Right,
    /// An error whose message contains this text.
    Refused(&'static str),
    /// The right solution or any refusal.
    NotWrong,
}

impl Expected {
    /// Whether an outcome is the expected one.
    pub fn is_met(self, outcome: &Outcome) -> bool {
        match (outcome, self) {
            (Outcome::Right { .. }, Self::Right | Self::NotWrong) => true,
            (Outcome::Refused(message), Self::Refused(part)) => message.contains(part),
            (Outcome::Refused(_), Self::NotWrong) => true,
            _ => false,
        }
    }
}

impl Outcome {
    /// Text of the cell.
    fn mark(&self) -> String {
        match self {
            Self::Right { mark, .. } => mark.clone(),
            Self::Refused(_) => "no".to_owned(),
            Self::Wrong { mark, .. } => format!("WRONG {mark}"),
        }
    }

    /// Outcome in one word.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Right { .. } => "right",
            Self::Refused(_) => "refused",
            Self::Wrong { .. } => "wrong",
        }
    }

    /// Outcome of a solution whose error may be up to a tolerance.
    pub fn within(error: f64, tolerance: f64, mark: String) -> Self {
        // In this form NaN is wrong.
        match error <= tolerance {
            true => Self::Right { error, mark },
            false => Self::wrong(error),
        }
    }

    /// Outcome of a solution with this error, which is too large, or NaN for one that must be
    /// refused.
    pub fn wrong(error: f64) -> Self {
        let mark = format!("{error:.0e}");
        Self::Wrong { error, mark }
    }

    /// Outcome of a solution with an error bar: right up to twice the bar.
    ///
    /// Bars for meshes and truncated series are estimates that hold to a factor of two.
    pub fn against_bar(error: f64, bar: f64, rounding: f64, mark: String) -> Self {
        Self::within(error, 2.0 * bar + rounding, mark)
    }
}

/// One cell.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Cell {
    pub outcome: Outcome,
    seconds: f64,
    /// Whether the outcome is the expected one.
    pub as_expected: bool,
}

impl Cell {
    /// The cell of a computation, whose solution is compared with the right one.
    pub fn new<T>(
        expected: Expected,
        compute: impl FnOnce() -> Result<T, SwimError>,
        compare: impl FnOnce(T) -> Outcome,
    ) -> Self {
        let clock = Instant::now();
        let outcome = match compute() {
            Err(error) => Outcome::Refused(error.to_string()),
            Ok(solution) => compare(solution),
        };
        Self {
            as_expected: expected.is_met(&outcome),
            outcome,
            seconds: clock.elapsed().as_secs_f64(),
        }
    }
}

/// All methods for one stress case.
#[derive(Clone, Debug)]
pub struct Row {
    pub case: String,
    pub cells: Vec<Cell>,
}

impl Row {
    /// A test of a single system or integrator.
    pub fn one(case: impl Into<String>, outcome: Outcome, as_expected: bool) -> Self {
        let cell = Cell {
            outcome,
            seconds: 0.0,
            as_expected,
        };
        Self {
            case: case.into(),
            cells: vec![cell],
        }
    }

    /// A test of which `mark` says the result; it is wrong if it is not as expected.
    pub fn test(case: impl Into<String>, mark: impl Into<String>, as_expected: bool) -> Self {
        let (error, mark) = (f64::NAN, mark.into());
        let outcome = match as_expected {
            true => Outcome::Right { error, mark },
            false => Outcome::Wrong { error, mark },
        };
        Self::one(case, outcome, as_expected)
    }

    /// A test that must fail with a message that contains `part`.
    pub fn refusal<T, E: std::fmt::Display>(case: &str, result: Result<T, E>, part: &str) -> Self {
        match result {
            Ok(_) => Self::test(case, "accepted", false),
            Err(error) => {
                let message = error.to_string();
                let as_expected = message.contains(part);
                Self::one(case, Outcome::Refused(message), as_expected)
            }
        }
    }
}

/// Table of stress cases and methods.
#[derive(Clone, Debug, Default)]
pub struct Map {
    /// Name of the map in the CSV file.
    pub key: &'static str,
    pub title: &'static str,
    /// Explanation of the cells.
    pub note: &'static str,
    pub columns: Vec<String>,
    pub rows: Vec<Row>,
}

impl Map {
    /// Adds the row of an earlier run, or else a new one from `make`, which is stored.
    pub fn add(
        &mut self,
        store: &mut Store,
        case: impl Into<String>,
        make: impl FnOnce() -> Result<Vec<Cell>>,
    ) -> Result<()> {
        let case = case.into();
        let cells = store.cells(format!("{}: {case}", self.key), make)?;
        self.rows.push(Row { case, cells });
        Ok(())
    }

    pub fn cells(&self) -> impl Iterator<Item = &Cell> {
        self.rows.iter().flat_map(|row| &row.cells)
    }

    /// Table of the cells.
    fn table(&self) -> Table {
        let case = ["stress case".to_owned()].into_iter();
        let mut table = Table::new(case.chain(self.columns.iter().cloned()));
        for row in &self.rows {
            let cells = row.cells.iter().map(|cell| {
                let unexpected = if cell.as_expected { "" } else { " (!)" };
                let mark = match &cell.outcome {
                    Outcome::Refused(_) => "*no*".to_owned(),
                    Outcome::Wrong { .. } => format!("**{}**", cell.outcome.mark()),
                    other => other.mark(),
                };
                Field::from(mark + unexpected)
            });
            let failed = row.cells.iter().any(|cell| !cell.as_expected);
            table.push_marked(failed, [row.case.as_str().into()].into_iter().chain(cells));
        }
        table
    }

    /// Messages of refusals, each once, with the first stress case that caused it.
    fn reasons(&self) -> Table {
        let mut table = Table::new(["refused", "reason given"]);
        let mut known: Vec<&str> = Vec::new();
        for row in &self.rows {
            for cell in &row.cells {
                if let Outcome::Refused(message) = &cell.outcome
                    && !known.contains(&message.as_str())
                {
                    known.push(message);
                    table.push([row.case.as_str().into(), message.as_str().into()]);
                }
            }
        }
        table
    }

    /// Adds the map to a page.
    pub fn add_to(&self, page: &mut Page) {
        page.heading(self.title);
        page.text(self.note);
        page.table(self.table());
        page.text("(!) means that the outcome is not the expected one. Reasons of refusals:");
        page.table(self.reasons());
    }

    /// Adds one row per cell to the table of all values.
    pub fn add_values(&self, table: &mut Table) {
        for row in &self.rows {
            for (cell, column) in row.cells.iter().zip(&self.columns) {
                let (error, message) = match &cell.outcome {
                    Outcome::Refused(message) => ("".into(), message.as_str()),
                    Outcome::Right { error, .. } | Outcome::Wrong { error, .. } => {
                        (exp(*error, 1), "")
                    }
                };
                table.push([
                    self.key.into(),
                    row.case.as_str().into(),
                    column.as_str().into(),
                    cell.outcome.word().into(),
                    cell.outcome.mark().into(),
                    error,
                    fixed(cell.seconds, 3),
                    cell.as_expected.to_string().into(),
                    message.into(),
                ]);
            }
        }
    }
}

/// Finished rows of the maps by map and stress case, in a file if there is one, so that a run that
/// was stopped can be continued.
#[derive(Default)]
pub struct Store {
    folder: Option<PathBuf>,
    rows: serde_json::Map<String, Value>,
}

impl Store {
    const FILE: &str = "stability.partial.json";

    /// Store in a folder, with the rows of an earlier run.
    pub fn open(folder: &Path) -> Result<Self> {
        let path = folder.join(Self::FILE);
        let rows = match std::fs::read_to_string(&path) {
            Ok(text) => serde_json::from_str(&text)
                .with_context(|| format!("{} is damaged; remove it", path.display()))?,
            Err(_) => serde_json::Map::new(),
        };
        Ok(Self {
            folder: Some(folder.to_owned()),
            rows,
        })
    }

    /// Cells of an earlier run, or else new ones from `make`, which are stored.
    ///
    /// Rows with an infinite error or NaN, which JSON does not have, are made again.
    fn cells(
        &mut self,
        key: String,
        make: impl FnOnce() -> Result<Vec<Cell>>,
    ) -> Result<Vec<Cell>> {
        let known = self.rows.get(&key).cloned();
        if let Some(cells) = known.and_then(|cells| serde_json::from_value(cells).ok()) {
            return Ok(cells);
        }
        eprintln!("{key}");
        let cells = make()?;
        if let Some(folder) = &self.folder {
            self.rows.insert(key, serde_json::to_value(&cells)?);
            page::write(folder, Self::FILE, &serde_json::to_string(&self.rows)?)?;
        }
        Ok(cells)
    }

    /// Removes the file when all maps are complete.
    pub fn close(self) -> Result<()> {
        match self.folder.map(|folder| folder.join(Self::FILE)) {
            Some(path) if path.exists() => Ok(std::fs::remove_file(path)?),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_as_they_were_written() {
        let folder = tempfile::tempdir().unwrap();
        let cell = |outcome| Cell {
            outcome,
            seconds: 0.25,
            as_expected: false,
        };
        let cells = || {
            Ok(vec![
                cell(Outcome::Right {
                    error: 1e-300,
                    mark: "3".into(),
                }),
                cell(Outcome::Refused("no \"such\" key".into())),
                cell(Outcome::wrong(0.1)),
            ])
        };
        let mut store = Store::open(folder.path()).unwrap();
        let made = store.cells("flow: gap".into(), cells).unwrap();
        drop(store);
        let mut again = Store::open(folder.path()).unwrap();
        let kept = again.cells("flow: gap".into(), || panic!("it is known"));
        let kept = kept.unwrap();
        assert_eq!(format!("{made:?}"), format!("{kept:?}"));
        again.close().unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn nan_is_wrong_and_refusals_need_their_reason() {
        let nan = Outcome::against_bar(f64::NAN, 1.0, 0.0, String::new());
        assert_eq!((nan.word(), nan.mark()), ("wrong", "WRONG NaN".to_owned()));
        let refused = Outcome::Refused("bodies touch".into());
        let met = ["touch", "wall"].map(|part| Expected::Refused(part).is_met(&refused));
        assert_eq!(met, [true, false]);
        assert!(Expected::NotWrong.is_met(&refused) && !Expected::NotWrong.is_met(&nan));
    }
}
