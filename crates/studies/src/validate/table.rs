//! The table of the validation, on the screen and in files.

use std::fmt::Write;

use super::row::{Basis, Row};

/// Heads of the columns.
pub const HEADINGS: [&str; 14] = [
    "case",
    "row",
    "exact",
    "computed",
    "error",
    "tolerance",
    "bar",
    "error / bar",
    "uncorrected",
    "gain",
    "dofs",
    "its",
    "s",
    "result",
];

impl Row {
    /// Cells of the row in the table.
    pub fn cells(&self) -> [String; HEADINGS.len()] {
        let shown = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        [
            self.group.to_owned(),
            self.name.clone(),
            format!("{:.9}", self.exact),
            format!("{:.9}", self.computed),
            format!("{:+.2e}", self.error),
            format!("{:.1e} ({})", self.tolerance, self.basis.mark()),
            shown(self.bar().map(|bar| format!("{bar:.2e}"))),
            shown(self.error_in_bars().map(|error| format!("{error:.2}"))),
            shown(
                self.uncorrected_error()
                    .map(|error| format!("{error:+.2e}")),
            ),
            shown(self.gain().map(|gain| format!("{gain:.1}"))),
            self.cost.dofs.to_string(),
            self.cost.iterations.to_string(),
            format!("{:.1}", self.cost.seconds),
            if self.passes() { "pass" } else { "FAIL" }.to_owned(),
        ]
    }
}

/// The table as Markdown, with aligned columns, so that it can be read as plain text.
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
        // Text is aligned to the left, numbers to the right.
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

/// Sources of the tolerances of these rows.
pub fn basis_notes(rows: &[Row]) -> Vec<String> {
    Basis::ALL
        .iter()
        .filter(|b| rows.iter().any(|row| row.basis == **b))
        .map(|basis| format!("({}) {}.", basis.mark(), basis.note()))
        .collect()
}

/// The rows as comma-separated values, with all digits.
pub fn csv(rows: &[Row]) -> String {
    let mut text = String::from(
        "case,row,exact,computed,error,tolerance,bar,error_in_bars,uncorrected_error,gain,dofs,iterations,seconds,result\n",
    );
    let shown = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value:?}"));
    for row in rows {
        let _ = writeln!(
            text,
            "{},\"{}\",{:?},{:?},{:?},{:?},{},{},{},{},{},{},{:?},{}",
            row.group,
            row.name.replace('"', "'"),
            row.exact,
            row.computed,
            row.error,
            row.tolerance,
            shown(row.bar()),
            shown(row.error_in_bars()),
            shown(row.uncorrected_error()),
            shown(row.gain()),
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
    use super::super::row::Cost;
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
    fn nan_fails() {
        assert!(row(2.01).passes());
        assert!(!row(2.03).passes());
        assert!(!row(1.97).passes());
        assert!(!row(f64::NAN).passes());
    }

    #[test]
    fn tables_have_one_line_per_row_of_equal_width() {
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
