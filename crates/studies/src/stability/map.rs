//! Outcomes of cells, maps as tables and pictures of cells, and their store between runs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
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
        let cells = store.cells(format!("{}: {case}", self.key), self.columns.len(), make)?;
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
    /// Number of rows that were not computed by this run.
    pub known: usize,
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
            known: 0,
        })
    }

    /// Adds the rows of `stability.csv` in the folder, the table of all values of an earlier run.
    ///
    /// # Errors
    /// A file that cannot be read or is not such a table.
    pub fn keep(&mut self, folder: &Path) -> Result<()> {
        let path = folder.join("stability.csv");
        let text = std::fs::read_to_string(&path)
            .with_context(|| format!("could not read {}; leave out --keep", path.display()))?;
        let mut rows: BTreeMap<String, Vec<Cell>> = BTreeMap::new();
        for line in text.lines().skip(1) {
            let fields = fields(line);
            let [
                map,
                case,
                _,
                word,
                mark,
                error,
                seconds,
                as_expected,
                message,
            ] = &fields[..]
            else {
                bail!(
                    "{}: {} fields in the line {line}",
                    path.display(),
                    fields.len()
                );
            };
            let number = |text: &str| text.parse().unwrap_or(f64::NAN);
            let (error, mark) = (number(error), mark.clone());
            let outcome = match word.as_str() {
                "right" => Outcome::Right { error, mark },
                "refused" => Outcome::Refused(message.clone()),
                "wrong" => Outcome::wrong(error),
                // Runs of integrators, which are always computed.
                _ => continue,
            };
            let cell = Cell {
                outcome,
                seconds: number(seconds),
                as_expected: as_expected == "true",
            };
            rows.entry(format!("{map}: {case}")).or_default().push(cell);
        }
        for (key, cells) in rows {
            self.rows.entry(key).or_insert(serde_json::to_value(cells)?);
        }
        Ok(())
    }

    /// Cells of an earlier run, or else new ones from `make`, which are stored.
    ///
    /// Rows with an infinite error or NaN, which JSON does not have, or with another number of
    /// cells are made again.
    fn cells(
        &mut self,
        key: String,
        count: usize,
        make: impl FnOnce() -> Result<Vec<Cell>>,
    ) -> Result<Vec<Cell>> {
        let known = self.rows.get(&key).cloned();
        let known: Option<Vec<Cell>> = known.and_then(|cells| serde_json::from_value(cells).ok());
        if let Some(cells) = known.filter(|cells| cells.len() == count) {
            self.known += 1;
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

/// Fields of a line of comma-separated values; a field with commas is between quotes, which are
/// doubled inside of it.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut is_quoted = false;
    let mut rest = line.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '"' if is_quoted && rest.next_if_eq(&'"').is_some() => {
                fields.last_mut().map(|f| f.push('"'))
            }
            '"' => {
                is_quoted = !is_quoted;
                None
            }
            ',' if !is_quoted => {
                fields.push(String::new());
                None
            }
            _ => fields.last_mut().map(|f| f.push(c)),
        };
    }
    fields
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_the_table_of_values_are_kept_and_the_others_made() {
        let folder = tempfile::tempdir().unwrap();
        let cell = |outcome| Cell {
            outcome,
            seconds: 0.25,
            as_expected: true,
        };
        let map = Map {
            key: "flow",
            columns: vec!["a".into(), "b".into()],
            rows: vec![Row {
                case: "gap, \"narrow\"".into(),
                cells: vec![
                    cell(Outcome::Refused("no \"such\" key, none".into())),
                    cell(Outcome::within(1e-3, 1.0, "1e-3, 2e-3".into())),
                ],
            }],
            ..Map::default()
        };
        let headings = "map stress_case method outcome mark error seconds as_expected message";
        let mut table = Table::new(headings.split(' '));
        map.add_values(&mut table);
        std::fs::write(folder.path().join("stability.csv"), table.csv()).unwrap();
        let mut store = Store::default();
        store.keep(folder.path()).unwrap();
        let mut again = Map {
            rows: Vec::new(),
            ..map.clone()
        };
        let known = || panic!("it is known");
        again.add(&mut store, &map.rows[0].case, known).unwrap();
        assert_eq!(format!("{:?}", again.rows), format!("{:?}", map.rows));
        let mut made = false;
        let new = || {
            made = true;
            Ok(Vec::new())
        };
        again.add(&mut store, "another", new).unwrap();
        assert!(made && store.known == 1);
    }

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
        let made = store.cells("flow: gap".into(), 3, cells).unwrap();
        drop(store);
        let mut again = Store::open(folder.path()).unwrap();
        let kept = again.cells("flow: gap".into(), 3, || panic!("it is known"));
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
