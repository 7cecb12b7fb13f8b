//! Outcomes of cells, and maps as tables of cells.

/// Outcome of one method for one stress case.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// The right solution: its error, and the text of the cell.
    Right { error: f64, mark: String },
    /// Refused with this message.
    Refused(String),
    /// A solution that is wrong, without an error message.
    Wrong { error: f64 },
}

/// One cell.
#[derive(Clone, Debug)]
pub struct Cell {
    pub outcome: Outcome,
    pub seconds: f64,
    /// Whether the outcome is the expected one.
    pub as_expected: bool,
}

/// All methods for one stress case.
#[derive(Clone, Debug)]
pub struct Row {
    pub case: String,
    pub cells: Vec<Cell>,
}

/// Table of stress cases and methods.
#[derive(Clone, Debug)]
pub struct Map {
    /// Name of the map in the CSV file.
    pub key: &'static str,
    pub title: &'static str,
    /// Explanation of the cells.
    pub note: &'static str,
    pub columns: Vec<String>,
    pub rows: Vec<Row>,
}

/// Test of a single system or integrator, with its outcome.
#[derive(Clone, Debug)]
pub struct Tried {
    pub name: String,
    pub outcome: String,
    pub as_expected: bool,
}

impl Map {
    pub fn cells(&self) -> impl Iterator<Item = &Cell> {
        self.rows.iter().flat_map(|row| &row.cells)
    }

    /// Messages of refusals, each once, with the first stress case that caused it.
    pub fn reasons(&self) -> Vec<(&str, &str)> {
        let mut reasons: Vec<(&str, &str)> = Vec::new();
        for row in &self.rows {
            for cell in &row.cells {
                if let Outcome::Refused(message) = &cell.outcome
                    && !reasons.iter().any(|(known, _)| known == message)
                {
                    reasons.push((message, &row.case));
                }
            }
        }
        reasons
    }
}

impl Outcome {
    /// Text of the cell.
    pub fn mark(&self) -> String {
        match self {
            Self::Right { mark, .. } => mark.clone(),
            Self::Refused(_) => "no".to_owned(),
            Self::Wrong { error } => format!("WRONG {error:.0e}"),
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

    pub fn is_wrong(&self) -> bool {
        matches!(self, Self::Wrong { .. })
    }

    /// Outcome of a solution with an error bar: right up to twice the bar.
    ///
    /// Bars for meshes and truncated series are estimates that hold to a factor of two.
    pub fn against_bar(error: f64, bar: f64, rounding: f64, mark: String) -> Self {
        // In this form NaN is wrong.
        if error <= 2.0 * bar + rounding {
            Self::Right { error, mark }
        } else {
            Self::Wrong { error }
        }
    }
}
