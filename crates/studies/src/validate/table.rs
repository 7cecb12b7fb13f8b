//! Rows of the validation table, and the table on the screen and in files.

use std::fmt::Write;

use swimmer::models::InstantaneousSolution;

use super::estimated::Estimated;

/// What rows cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    pub dofs: usize,
    /// Largest number of iterations of a solve.
    pub iterations: usize,
    pub seconds: f64,
}

impl Cost {
    pub fn of(instant: &InstantaneousSolution) -> Self {
        Self {
            dofs: instant.dofs.total,
            iterations: instant.solver.iterations,
            seconds: instant.seconds.total,
        }
    }

    /// Adds another solve: sizes do not add up, seconds do.
    pub fn add(&mut self, other: &Self) {
        self.dofs = self.dofs.max(other.dofs);
        self.iterations = self.iterations.max(other.iterations);
        self.seconds += other.seconds;
    }
}

/// A computed value beside the exact one.
#[derive(Clone, Debug)]
pub struct Row {
    /// Key of the reference: `A` to `H`, or the name of a method's property.
    pub group: &'static str,
    pub name: String,
    pub exact: f64,
    pub computed: f64,
    /// What the row's error is judged by.
    pub scale: f64,
    /// Error over the scale.
    pub error: f64,
    pub tolerance: f64,
    /// Where the tolerance comes from.
    pub basis: Basis,
    /// What came with the value about its error.
    pub estimated: Option<Estimated>,
    pub cost: Cost,
}

/// Where a tolerance comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Basis {
    Interpolation,
    Halving,
    Order,
    Required,
    Flat,
    Promised,
}

impl Basis {
    const ALL: [Self; 6] = [
        Self::Interpolation,
        Self::Halving,
        Self::Order,
        Self::Required,
        Self::Flat,
        Self::Promised,
    ];

    fn mark(self) -> char {
        match self {
            Self::Interpolation => 'a',
            Self::Halving => 'b',
            Self::Order => 'c',
            Self::Required => 'd',
            Self::Flat => 'e',
            Self::Promised => 'f',
        }
    }

    fn note(self) -> &'static str {
        match self {
            Self::Interpolation => {
                "twice the energy of the interpolation error of the exact flow around one sphere, on a mesh of the same sizes around it \
                 alone; matrix entries are judged by the largest entry"
            }
            Self::Halving => {
                "a third of the change from the mesh of twice the surface size: what is left at second order or better; besides, as (a), \
                 for the lubrication flow in a gap, whose elements do not depend on that size"
            }
            Self::Order => {
                "theory: 4 curved, at least 3.3 before the asymptotic range; 2 straight, by geometry (absolute difference)"
            }
            Self::Required => {
                "required: with default settings 1e-3 for a step of the stroke and hence for speeds, 1e-2 for the net displacement; \
                 at surface size 0.2 and on the mesh file 1e-4 for speeds, on the mesh file 1e-3 for forces"
            }
            Self::Flat => {
                "twice the deficit of radius of the ball that has the volume inside the flat facets"
            }
            Self::Promised => {
                "the tolerance that the model was asked for: 1e-6 of the largest entry of a resistance, 2e-5 of a stroke's net displacement, for \
                 which resistances, and hence forces and speeds of instants, are computed to 1e-6"
            }
        }
    }
}

impl Row {
    /// A value judged by its error relative to the exact one.
    pub fn relative(
        group: &'static str,
        name: impl Into<String>,
        [exact, computed]: [f64; 2],
        (tolerance, basis): (f64, Basis),
        cost: Cost,
    ) -> Self {
        Self::scaled(
            group,
            name,
            [exact, computed],
            exact,
            (tolerance, basis),
            cost,
        )
    }

    /// A value judged by its error over `scale`.
    pub fn scaled(
        group: &'static str,
        name: impl Into<String>,
        [exact, computed]: [f64; 2],
        scale: f64,
        (tolerance, basis): (f64, Basis),
        cost: Cost,
    ) -> Self {
        Self {
            group,
            name: name.into(),
            exact,
            computed,
            scale,
            error: (computed - exact) / scale.abs(),
            tolerance,
            basis,
            estimated: None,
            cost,
        }
    }

    /// The row with what came with its value about its error.
    pub fn with(self, estimated: Option<Estimated>) -> Self {
        Self { estimated, ..self }
    }

    /// The row in a unit of so many.
    pub fn in_units_of(self, unit: f64) -> Self {
        Self {
            exact: self.exact / unit,
            computed: self.computed / unit,
            scale: self.scale / unit,
            estimated: self.estimated.map(|own| own.times(1.0 / unit)),
            ..self
        }
    }

    /// NaN passes nothing.
    pub fn passes(&self) -> bool {
        self.error.abs() <= self.tolerance
    }

    /// The row as the table shows it.
    pub fn cells(&self) -> [String; HEADINGS.len()] {
        let shown = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        let ratio = self.effectivity().map(|(ratio, means)| match means {
            true => format!("{ratio:.2}"),
            false => format!("({ratio:.2})"),
        });
        let (corrected, gain) = self.corrected().unzip();
        [
            self.group.to_owned(),
            self.name.clone(),
            format!("{:.9}", self.exact),
            format!("{:.9}", self.computed),
            format!("{:+.2e}", self.error),
            format!("{:.1e} ({})", self.tolerance, self.basis.mark()),
            shown(self.bar().map(|bar| format!("{bar:.2e}"))),
            shown(ratio),
            shown(corrected.map(|value| format!("{value:.9}"))),
            shown(gain.map(|gain| format!("{gain:.1}"))),
            self.cost.dofs.to_string(),
            self.cost.iterations.to_string(),
            format!("{:.1}", self.cost.seconds),
            if self.passes() { "pass" } else { "FAIL" }.to_owned(),
        ]
    }
}

/// What the columns of the table are.
pub const HEADINGS: [&str; 14] = [
    "case",
    "row",
    "exact",
    "computed",
    "error",
    "tolerance",
    "estimated",
    "ratio",
    "corrected",
    "gain",
    "dofs",
    "its",
    "s",
    "result",
];

/// The table as Markdown, aligned for reading as plain text too.
pub fn markdown(rows: &[Row], notes: &[String]) -> String {
    const LAST: usize = HEADINGS.len() - 1;
    let mut lines = vec![HEADINGS.map(str::to_owned)];
    lines.extend(rows.iter().map(Row::cells));
    let widths: Vec<usize> = (0..HEADINGS.len())
        .map(|column| {
            lines
                .iter()
                .map(|line| line[column].chars().count())
                .max()
                .unwrap_or(0)
        })
        .collect();
    let mut text = String::new();
    for (number, line) in lines.iter().enumerate() {
        let cells = line.iter().zip(&widths).enumerate();
        // Words to the left, numbers to the right.
        let padded = cells.map(|(column, (cell, &width))| match column {
            0 | 1 | LAST => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        text.push_str(&format!("| {} |\n", padded.collect::<Vec<_>>().join(" | ")));
        if number == 0 {
            let rules = widths
                .iter()
                .enumerate()
                .map(|(column, &width)| match column {
                    0 | 1 | LAST => format!(":{}", "-".repeat(width + 1)),
                    _ => format!("{}:", "-".repeat(width + 1)),
                });
            text.push_str(&format!("|{}|\n", rules.collect::<Vec<_>>().join("|")));
        }
    }
    text.push('\n');
    for line in basis_notes(rows) {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{line}");
    }
    for note in notes {
        let _ = writeln!(text, "* {note}");
    }
    text
}

/// Where the tolerances of these rows come from.
pub fn basis_notes(rows: &[Row]) -> Vec<String> {
    Basis::ALL
        .iter()
        .filter(|b| rows.iter().any(|row| row.basis == **b))
        .map(|basis| format!("({}) {}.", basis.mark(), basis.note()))
        .collect()
}

/// The rows as comma-separated values, numbers in full.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "case,row,exact,computed,error,tolerance,estimated,ratio,ratio_means_something,corrected,gain,dofs,iterations,seconds,result\n",
    );
    let shown = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
    for row in rows {
        let (ratio, means) = row.effectivity().unzip();
        let (corrected, gain) = row.corrected().unzip();
        let _ = writeln!(
            text,
            "{},\"{}\",{:?},{:?},{:?},{:?},{},{},{},{},{},{},{},{:?},{}",
            row.group,
            row.name.replace('"', "'"),
            row.exact,
            row.computed,
            row.error,
            row.tolerance,
            shown(row.bar()),
            shown(ratio),
            means.map_or(String::new(), |means| means.to_string()),
            shown(corrected),
            shown(gain),
            row.cost.dofs,
            row.cost.iterations,
            row.cost.seconds,
            if row.passes() { "pass" } else { "fail" },
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(computed: f64) -> Row {
        Row::relative(
            "A",
            "drag",
            [2.0, computed],
            (1e-2, Basis::Interpolation),
            Cost::default(),
        )
    }

    #[test]
    fn what_is_no_number_fails() {
        assert!(row(2.01).passes());
        assert!(!row(2.03).passes());
        assert!(!row(1.97).passes());
        assert!(!row(f64::NAN).passes());
    }

    #[test]
    fn tables_have_a_line_a_row_of_equal_width() {
        let text = markdown(&[row(2.0), row(3.0)], &["a note".to_owned()]);
        let table: Vec<&str> = text
            .lines()
            .take_while(|line| line.starts_with('|'))
            .collect();
        assert_eq!(table.len(), 4);
        assert!(
            table
                .iter()
                .all(|line| line.chars().count() == table[0].chars().count())
        );
        assert!(table[2].ends_with("| pass   |") && table[3].ends_with("| FAIL   |"));
        assert_eq!(csv(&[row(2.0)]).lines().count(), 2);
    }
}
