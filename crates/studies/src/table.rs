//! Tables of values: one type, written as Markdown, CSV and HTML.

/// Width up to which columns of Markdown tables are aligned.
const MAX_ALIGNED_WIDTH: usize = 60;

/// A value: its text on pages, and its text with all digits in CSV files.
#[derive(Clone, Debug)]
pub struct Cell {
    page: String,
    file: String,
    is_number: bool,
}

impl Cell {
    fn number(page: String, value: f64) -> Self {
        Self {
            page,
            file: format!("{value:?}"),
            is_number: true,
        }
    }

    /// A value with another text on pages.
    pub fn shown(self, page: impl Into<String>) -> Self {
        let page = page.into();
        Self { page, ..self }
    }
}

impl<T: Into<String>> From<T> for Cell {
    fn from(text: T) -> Self {
        let page: String = text.into();
        Self {
            file: page.clone(),
            page,
            is_number: false,
        }
    }
}

/// A number with this many decimals.
pub fn fixed(value: f64, decimals: usize) -> Cell {
    Cell::number(format!("{value:.decimals$}"), value)
}

/// A number in scientific notation with this many decimals.
pub fn exp(value: f64, decimals: usize) -> Cell {
    Cell::number(format!("{value:.decimals$e}"), value)
}

/// A number in scientific notation with its sign and two decimals.
pub fn signed(value: f64) -> Cell {
    Cell::number(format!("{value:+.2e}"), value)
}

/// A ratio as a percentage without decimals.
pub fn percent(ratio: f64) -> Cell {
    Cell::number(format!("{:.0} %", 100.0 * ratio), ratio)
}

/// A number.
pub fn count(number: usize) -> Cell {
    Cell {
        is_number: true,
        ..number.to_string().into()
    }
}

/// A value that is missing: a dash on pages, nothing in CSV files.
pub fn missing() -> Cell {
    Cell {
        page: "-".to_owned(),
        file: String::new(),
        is_number: true,
    }
}

/// The cell of a value that may be missing.
pub fn optional<T>(value: Option<T>, cell: impl FnOnce(T) -> Cell) -> Cell {
    value.map_or_else(missing, cell)
}

/// Columns with headings, and rows of cells.
#[derive(Clone, Debug, Default)]
pub struct Table {
    headings: Vec<String>,
    rows: Vec<Vec<Cell>>,
    /// Whether each row is marked as failed.
    failed: Vec<bool>,
}

impl Table {
    pub fn new<H: Into<String>>(headings: impl IntoIterator<Item = H>) -> Self {
        Self {
            headings: headings.into_iter().map(Into::into).collect(),
            ..Self::default()
        }
    }

    /// Adds a row; cells at its end may be left out.
    pub fn push(&mut self, cells: impl IntoIterator<Item = Cell>) {
        self.push_marked(false, cells);
    }

    /// Adds a row that is marked if it failed.
    pub fn push_marked(&mut self, failed: bool, cells: impl IntoIterator<Item = Cell>) {
        let mut cells: Vec<Cell> = cells.into_iter().collect();
        cells.resize(self.headings.len(), "".into());
        self.rows.push(cells);
        self.failed.push(failed);
    }

    /// Whether the cells of a column are numbers, or missing ones.
    fn is_numeric(&self, column: usize) -> bool {
        let mut cells = self.rows.iter().map(|row| &row[column]);
        cells.all(|cell| cell.is_number || cell.page.is_empty())
    }

    /// Lines with aligned columns, so that they can be read as plain text.
    ///
    /// Text is aligned to the left, numbers to the right.
    pub fn markdown(&self) -> String {
        let (mut head, mut rule) = ("|".to_owned(), "|".to_owned());
        let mut lines = vec!["|".to_owned(); self.rows.len()];
        for (column, heading) in self.headings.iter().enumerate() {
            let is_numeric = self.is_numeric(column);
            let pages = self
                .rows
                .iter()
                .map(|row| row[column].page.replace('\n', " "));
            let pages: Vec<String> = pages.collect();
            let width = pages.iter().map(|page| page.chars().count());
            let width = width.fold(heading.chars().count(), usize::max);
            let width = width.min(MAX_ALIGNED_WIDTH);
            let padded = |cell: &str| match is_numeric {
                true => format!(" {cell:>width$} |"),
                false => format!(" {cell:<width$} |"),
            };
            head += &padded(heading);
            let dashes = "-".repeat(width + 1);
            rule += &match is_numeric {
                true => format!("{dashes}:|"),
                false => format!(":{dashes}|"),
            };
            for (line, page) in lines.iter_mut().zip(&pages) {
                *line += &padded(page);
            }
        }
        lines.splice(0..0, [head, rule]);
        lines.join("\n") + "\n"
    }

    /// Comma-separated values with all digits; texts with commas or quotes are between quotes,
    /// which are doubled inside of them (RFC 4180). Line ends become spaces.
    pub fn csv(&self) -> String {
        let quoted = |text: &String| match text.contains([',', '"', '\n']) {
            true => format!("\"{}\"", text.replace('"', "\"\"").replace('\n', " ")),
            false => text.clone(),
        };
        let line = |cells: Vec<String>| cells.join(",") + "\n";
        let lines = self.rows.iter();
        let lines = lines.map(|row| line(row.iter().map(|cell| quoted(&cell.file)).collect()));
        line(self.headings.iter().map(quoted).collect()) + &lines.collect::<String>()
    }

    /// A table element; failed rows have the class `bad`.
    pub fn html(&self) -> String {
        let row = |tag: &str, cells: &mut dyn Iterator<Item = &String>| -> String {
            // The marks of Markdown.
            let plain = |cell: &String| escape(&cell.replace(['*', '`'], ""));
            let cells = cells.map(|cell| format!("<{tag}>{}</{tag}>", plain(cell)));
            cells.collect()
        };
        let head = row("th", &mut self.headings.iter());
        let lines = self.rows.iter().zip(&self.failed).map(|(cells, failed)| {
            let class = if *failed { " class=\"bad\"" } else { "" };
            let cells = row("td", &mut cells.iter().map(|cell| &cell.page));
            format!("<tr{class}>{cells}</tr>\n")
        });
        let lines: String = lines.collect();
        format!(
            "<div class=\"table\"><table><thead><tr>{head}</tr></thead><tbody>\n{lines}</tbody></table></div>"
        )
    }
}

/// Text with the special characters of HTML replaced.
pub fn escape(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;")
}

/// Middle of sorted values, the upper one of two; NaN if there is none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::new(["case", "error", "dofs"]);
        table.push(["a < b".into(), exp(0.125, 1), count(10)]);
        table.push_marked(true, ["c, \"d\"".into(), missing()]);
        table
    }

    #[test]
    fn one_table_is_written_in_three_ways() {
        let markdown = table().markdown();
        let lines: Vec<&str> = markdown.lines().collect();
        assert_eq!(lines[0], "| case   |  error | dofs |");
        assert_eq!(lines[1], "|:-------|-------:|-----:|");
        assert_eq!(lines[2], "| a < b  | 1.2e-1 |   10 |");
        assert_eq!(lines[3], "| c, \"d\" |      - |      |");
        assert_eq!(
            table().csv(),
            "case,error,dofs\na < b,0.125,10\n\"c, \"\"d\"\"\",,\n"
        );
        let html = table().html();
        assert!(html.contains("<tr><td>a &lt; b</td><td>1.2e-1</td>"));
        assert!(html.contains("<tr class=\"bad\"><td>c, \"d\"</td><td>-</td>"));
    }

    #[test]
    fn the_median_is_the_middle_of_sorted_values() {
        assert_eq!(median(vec![3.0, 1.0, 2.0, 4.0]), 3.0);
        assert!(median(Vec::new()).is_nan());
    }
}
