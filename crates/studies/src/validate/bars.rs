//! Errors of all rows in units of their error bars, and what the corrections gained.

use super::row::Row;

/// Largest error of a single row, in error bars.
///
/// A bar covers 95 of 100 errors, so some rows of a long table are outside; twice the bar covers
/// all.
pub const LARGEST: f64 = 2.0;

/// Footnotes on the error bars: explanation, rows outside one bar, and the gain of the corrections.
pub fn notes(rows: &[Row]) -> Vec<String> {
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
            within(LARGEST),
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

/// Panics unless the correction of a row is significant and its error bar holds.
///
/// The uncorrected error is above the bar; the error is within [`LARGEST`] bars; and it is within
/// one bar or below a quarter of the uncorrected error. Of the error of a single sphere, curved
/// elements of half a radius, the coarsest in the tests, leave 4 percent (`stokes::estimate`).
/// Where the errors of several bodies cancel, what is left of them need not, hence the larger
/// fraction.
#[cfg(test)]
pub fn assert_corrected(row: &Row) {
    const LEAST_GAIN: f64 = 4.0;
    let Some((bars, (uncorrected, bar))) = row
        .error_in_bars()
        .zip(row.uncorrected_error().zip(row.bar()))
    else {
        panic!("{}: no correction or no error bar", row.name);
    };
    let error = row.error.abs();
    assert!(
        uncorrected.abs() > bar
            && bars <= LARGEST
            && (bars <= 1.0 || LEAST_GAIN * error <= uncorrected.abs()),
        "{}: error {error:.3e}, bar {bar:.3e}, uncorrected {uncorrected:.3e}",
        row.name,
    );
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::super::estimated::Estimated;
    use super::super::row::{Basis, Cost};
    use super::*;

    /// A row with an error of 0.1, or 0.025 of its scale.
    fn row(estimated: Estimated) -> Row {
        Row::scaled(
            "A",
            "drag",
            [2.0, 2.1],
            4.0,
            (1.0, Basis::Order),
            Cost::default(),
        )
        .with(Some(estimated))
    }

    fn corrected(bar: f64) -> Row {
        row(Estimated {
            removed: Some(0.4),
            bar,
        })
    }

    #[test]
    fn a_corrected_row_has_a_bar_and_a_gain() {
        let row = corrected(0.08);
        assert!((row.bar().unwrap() - 0.02).abs() < 1e-12);
        assert!((row.error_in_bars().unwrap() - 1.25).abs() < 1e-12);
        assert!((row.uncorrected_error().unwrap() - 0.125).abs() < 1e-12);
        assert!((row.gain().unwrap() - 5.0).abs() < 1e-9);
        assert_corrected(&row);
    }

    #[test]
    fn errors_above_two_bars_fail_whatever_the_tolerance() {
        assert!(corrected(0.051).passes());
        assert!(!corrected(0.049).passes());
        assert!(!corrected(f64::NAN).passes());
    }

    #[test]
    #[should_panic(expected = "uncorrected")]
    fn a_correction_below_its_bar_shows_nothing() {
        assert_corrected(&corrected(0.6));
    }

    #[test]
    fn rows_outside_their_bars_are_listed() {
        let rows = [corrected(0.2), corrected(0.08), row(Estimated::bound(0.3))];
        let notes = notes(&rows);
        assert_eq!(notes.len(), 3);
        let values = "Of 2 corrected values with an error bar, 1 have errors within one bar and 2 within two";
        assert!(notes[1].starts_with(values), "{}", notes[1]);
        assert!(notes[1].ends_with("median gain 5.0. Outside one bar: A drag, 1.25."));
        assert!(
            notes[2].ends_with("median of bar over error 3.0."),
            "{}",
            notes[2]
        );
    }
}
