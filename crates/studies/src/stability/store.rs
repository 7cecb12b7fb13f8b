//! Finished rows of the maps, so that a run that was stopped can be continued.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use serde_json::{Map, Value, json};

use super::map::{Cell, Outcome, Row};

/// Rows by map and stress case, in a file if there is one.
pub struct Store {
    path: Option<PathBuf>,
    rows: Map<String, Value>,
}

impl Store {
    /// Store without a file.
    #[cfg(test)]
    pub fn none() -> Self {
        Self {
            path: None,
            rows: Map::new(),
        }
    }

    /// Store in a folder, with the rows of an earlier run.
    pub fn open(folder: &Path) -> Result<Self> {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("could not create the folder {}", folder.display()))?;
        let path = folder.join("stability.partial.json");
        let rows = match std::fs::read_to_string(&path) {
            Ok(text) => serde_json::from_str(&text)
                .with_context(|| format!("{} is damaged; remove it", path.display()))?,
            Err(_) => Map::new(),
        };
        Ok(Self {
            path: Some(path),
            rows,
        })
    }

    /// Row of an earlier run, or else a new one from `make`, which is stored.
    pub fn row(
        &mut self,
        map: &str,
        case: &str,
        make: impl FnOnce() -> Result<Vec<Cell>>,
    ) -> Result<Row> {
        let key = format!("{map}: {case}");
        let known = self.rows.get(&key).and_then(Value::as_array);
        if let Some(cells) = known.and_then(|list| list.iter().map(read).collect::<Option<_>>()) {
            return Ok(Row {
                case: case.to_owned(),
                cells,
            });
        }
        eprintln!("{key}");
        let cells = make()?;
        if let Some(path) = &self.path {
            self.rows.insert(key, cells.iter().map(write).collect());
            let text = serde_json::to_string(&self.rows)?;
            std::fs::write(path, text)
                .with_context(|| format!("could not write {}", path.display()))?;
        }
        Ok(Row {
            case: case.to_owned(),
            cells,
        })
    }

    /// Removes the file when all maps are complete.
    pub fn close(self) -> Result<()> {
        match self.path {
            Some(path) if path.exists() => Ok(std::fs::remove_file(path)?),
            _ => Ok(()),
        }
    }
}

fn write(cell: &Cell) -> Value {
    let (error, text) = match &cell.outcome {
        Outcome::Right { error, mark } => (*error, mark.as_str()),
        Outcome::Refused(message) => (0.0, message.as_str()),
        Outcome::Wrong { error } => (*error, ""),
    };
    // JSON has no NaN, so errors are written as text.
    json!({
        "outcome": cell.outcome.word(), "error": error.to_string(), "text": text, "seconds": cell.seconds, "as_expected": cell.as_expected,
    })
}

fn read(value: &Value) -> Option<Cell> {
    let text = value["text"].as_str()?.to_owned();
    let error = value["error"].as_str()?.parse().ok()?;
    Some(Cell {
        outcome: match value["outcome"].as_str()? {
            "right" => Outcome::Right { error, mark: text },
            "refused" => Outcome::Refused(text),
            "wrong" => Outcome::Wrong { error },
            _ => return None,
        },
        seconds: value["seconds"].as_f64()?,
        as_expected: value["as_expected"].as_bool()?,
    })
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
                cell(Outcome::Wrong { error: f64::NAN }),
            ])
        };
        let mut store = Store::open(folder.path()).unwrap();
        let made = store.row("flow", "gap", cells).unwrap();
        drop(store);
        let mut again = Store::open(folder.path()).unwrap();
        let kept = again.row("flow", "gap", || panic!("it is known")).unwrap();
        assert_eq!(format!("{made:?}"), format!("{kept:?}"));
        again.close().unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
