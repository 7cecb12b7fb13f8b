//! The pages of the validation: table, footnotes, and the errors in units of their error bars.

use anyhow::Result;

use super::row::{BASES, MAX_ERROR_IN_BARS, Row};
use crate::chart::{LogLog, Series};
use crate::page::Page;
use crate::table::{Cell, Table, count, exp, fixed, median, optional, signed};

/// Names of the cases, in the order of the page.
const CASES: [(&str, &str); 11] = [
    ("A", "one sphere in a concentric ball, and spheroids"),
    ("B", "two spheres"),
    ("D", "collinear spheres in a ball"),
    ("E", "the three-sphere swimmer"),
    ("H", "one sphere in a cylinder"),
    ("J", "hinges, springs and flows"),
    ("K", "bodies of other shapes"),
    ("L", "fluids with inertia"),
    ("M", "fluids whose viscosity depends on the shear rate"),
    ("N", "bodies that deform"),
    ("order", "observed orders"),
];

/// The table of these rows.
pub fn table<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Table {
    const HEADINGS: &str = "case,row,exact,computed,error,tolerance,bar,error / bar,uncorrected,\
         gain,dofs,its,s,result";
    let mut table = Table::new(HEADINGS.split(','));
    for row in rows {
        let letter = row.basis.letter();
        let tolerance = exp(row.tolerance, 1);
        let result: Cell = if row.passes() { "pass" } else { "FAIL" }.into();
        let cells = [
            row.group.into(),
            row.name.clone().into(),
            fixed(row.exact, 9),
            fixed(row.computed, 9),
            signed(row.error),
            tolerance.shown(format!("{:.1e} ({letter})", row.tolerance)),
            optional(row.bar(), |bar| exp(bar, 2)),
            optional(row.error_in_bars(), |error| fixed(error, 2)),
            optional(row.uncorrected_error(), signed),
            optional(row.gain(), |gain| fixed(gain, 1)),
            count(row.cost.dofs),
            count(row.cost.iterations),
            fixed(row.cost.seconds, 1),
            result,
        ];
        table.push_marked(!row.passes(), cells);
    }
    table
}

/// Sources of the tolerances of these rows, and then `notes`.
fn footnotes(rows: &[Row], notes: &[String]) -> Vec<String> {
    let used = |(basis, _): &&(_, &str)| rows.iter().any(|row| row.basis == *basis);
    let bases = BASES.iter().filter(used);
    let bases = bases.map(|(basis, note)| format!("* ({}) {note}.", basis.letter()));
    bases
        .chain(notes.iter().map(|note| format!("* {note}")))
        .collect()
}

/// Notes on the error bars: explanation, rows outside one bar, and the gain of the corrections.
pub fn bar_notes(rows: &[Row]) -> Vec<String> {
    let mut notes = vec![
        "computed: the answer of the program, from which elements subtract the estimated discretisation error; bar: its error bar, relative to the \
         same scale as the error; error / bar: where the exact value is uncertain too, as for B and on the mesh file, the bar includes this; uncorrected: the error of the value before this correction; gain: the factor by which the correction reduced the error."
            .to_owned(),
    ];
    for (kind, is_corrected) in [
        ("corrected values", true),
        ("values without a correction", false),
    ] {
        let of_kind = |row: &&Row| row.uncorrected_error().is_some() == is_corrected;
        let barred: Vec<(&Row, f64)> = (rows.iter().filter(of_kind))
            .filter_map(|row| Some((row, row.error_in_bars()?)))
            .collect();
        if barred.is_empty() {
            continue;
        }
        let within = |bars: f64| barred.iter().filter(|(_, error)| *error <= bars).count();
        let slack = median(barred.iter().map(|(_, error)| 1.0 / error).collect());
        let mut note = format!(
            "Of {} {kind} with an error bar, {} have errors within one bar and {} within two; median of bar over error {slack:.1}",
            barred.len(),
            within(1.0),
            within(MAX_ERROR_IN_BARS),
        );
        let gains: Vec<f64> = barred.iter().filter_map(|(row, _)| row.gain()).collect();
        if !gains.is_empty() {
            note += &format!(", median gain {:.1}", median(gains));
        }
        let outside: Vec<String> = (barred.iter().filter(|(_, error)| *error > 1.0))
            .map(|(row, error)| format!("{} {}, {error:.2}", row.group, row.name))
            .collect();
        note += &match outside.is_empty() {
            true => ".".to_owned(),
            false => format!(". Outside one bar: {}.", outside.join("; ")),
        };
        notes.push(note);
    }
    notes
}

/// The page with one table.
pub fn page(rows: &[Row], notes: &[String]) -> Page {
    let mut page = Page::new("Validation", "validate", "");
    page.table(table(rows));
    page.text(footnotes(rows, notes).join("\n"));
    page
}

/// The page with one table per case and the chart of all errors.
pub fn overview(rows: &[Row], notes: &[String]) -> Result<Page> {
    let text = "Computed values against exact ones: spectral solutions and closed forms, none from a finite-element code.";
    let mut page = Page::new("Validation", "validate", text);
    let passed = rows.iter().filter(|row| row.passes()).count();
    let seconds: f64 = rows.iter().map(|row| row.cost.seconds).fold(0.0, f64::max);
    let largest = rows.iter().map(|row| row.cost.dofs).max().unwrap_or(0);
    let passed = format!("{passed} of {}", rows.len());
    page.figures([
        (passed, "rows within their tolerance"),
        (largest.to_string(), "dofs in the largest solve"),
        (format!("{seconds:.1} s"), "longest row"),
    ]);
    page.heading("Errors against seconds");
    page.chart(
        "errors",
        "error of every row over its seconds",
        &errors(rows),
    )?;
    for (group, name) in groups(rows) {
        page.heading(name);
        page.table(table(rows.iter().filter(|row| row.group == group)));
    }
    page.heading("Where the tolerances come from");
    for line in footnotes(rows, notes) {
        page.text(line);
    }
    Ok(page)
}

/// Cases that occur, with their names.
fn groups(rows: &[Row]) -> impl Iterator<Item = (&'static str, String)> {
    let occurs = |(group, _): &&(&str, _)| rows.iter().any(|row| row.group == *group);
    let known = CASES.iter().filter(occurs);
    known.map(|&(group, name)| (group, format!("{group}: {name}")))
}

fn errors(rows: &[Row]) -> LogLog {
    // Orders of convergence have no relative error.
    let groups = groups(rows).filter(|(group, _)| *group != "order");
    let series = groups.map(|(group, name)| {
        let rows = rows.iter().filter(|row| row.group == group);
        let points = rows.map(|row| (row.cost.seconds, row.error.abs()));
        Series::new(name, points)
    });
    let title = "error of every row over its seconds";
    LogLog::new(title, ["seconds", "error"], series, false)
}

#[cfg(test)]
mod tests {
    use super::super::row::{Basis, Cost, Estimated};
    use super::*;

    /// A row with an error of 0.1, or 0.025 of its scale.
    fn row(estimated: Estimated) -> Row {
        let tolerance = (1.0, Basis::Order);
        Row::scaled("A", "drag", [2.0, 2.1], 4.0, tolerance, Cost::default()).with(estimated)
    }

    fn corrected(bar: f64) -> Row {
        let removed = Some(0.4);
        row(Estimated { removed, bar })
    }

    #[test]
    fn rows_outside_their_bars_are_listed() {
        let rows = [corrected(0.2), corrected(0.08), row(Estimated::bound(0.3))];
        let notes = bar_notes(&rows);
        assert_eq!(notes.len(), 3);
        let values = "Of 2 corrected values with an error bar, 1 have errors within one bar and 2 within two";
        assert!(notes[1].starts_with(values), "{}", notes[1]);
        assert!(notes[1].ends_with("median gain 5.0. Outside one bar: A drag, 1.25."));
        let last = &notes[2];
        assert!(last.ends_with("median of bar over error 3.0."), "{last}");
    }

    #[test]
    fn tables_say_which_rows_pass_and_why() {
        let rows = [corrected(0.2), corrected(0.01)];
        let text = page(&rows, &["a note".to_owned()]).markdown();
        assert!(text.contains("| pass   |") && text.contains("| FAIL   |"));
        assert!(text.contains("(c) theory: 4 curved") && text.ends_with("* a note\n"));
        let mut bases = BASES.iter().zip('a'..);
        assert!(bases.all(|((basis, _), letter)| basis.letter() == letter));
    }
}
