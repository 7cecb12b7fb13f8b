//! What a cell of a map can come to, and maps as tables of cells.

/// What one way came to on one hardship.
#[derive(Clone, Debug)]
pub enum Outcome {
    /// The right answer: its error, and what is written into the cell.
    Right { error: f64, mark: String },
    /// The message.
    Refused(String),
    /// An answer that claims to be one and is not.
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

/// All ways on one hardship.
#[derive(Clone, Debug)]
pub struct Row {
    pub hardship: String,
    pub cells: Vec<Cell>,
}

/// Hardships against ways.
#[derive(Clone, Debug)]
pub struct Map {
    /// Name in the table of all cells.
    pub key: &'static str,
    pub title: &'static str,
    /// How to read it.
    pub note: &'static str,
    pub columns: Vec<String>,
    pub rows: Vec<Row>,
}

/// Something tried that is no scene, and what it came to.
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

    /// The messages given, each once, with the hardship that it was first given for.
    pub fn reasons(&self) -> Vec<(&str, &str)> {
        let mut reasons: Vec<(&str, &str)> = Vec::new();
        for row in &self.rows {
            for cell in &row.cells {
                if let Outcome::Refused(message) = &cell.outcome
                    && !reasons.iter().any(|(known, _)| known == message)
                {
                    reasons.push((message, &row.hardship));
                }
            }
        }
        reasons
    }
}

impl Outcome {
    /// What is written into the cell.
    pub fn mark(&self) -> String {
        match self {
            Self::Right { mark, .. } => mark.clone(),
            Self::Refused(_) => "no".to_owned(),
            Self::Wrong { error } => format!("WRONG {error:.0e}"),
        }
    }

    /// In one word.
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

    /// An error against the bar that came with it: bars of meshes and truncated series are estimates that hold to a factor of two.
    pub fn against_bar(error: f64, bar: f64, rounding: f64, mark: String) -> Self {
        // A NaN is wrong.
        if error <= 2.0 * bar + rounding {
            Self::Right { error, mark }
        } else {
            Self::Wrong { error }
        }
    }
}
