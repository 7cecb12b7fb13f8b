//! Estimated over true errors of all rows.

use super::estimated::WINDOW;
use super::row::Row;

/// Footnotes on the estimates: explanation, rows outside [`WINDOW`], and upper bounds separately.
pub fn notes(rows: &[Row]) -> Vec<String> {
    let compared = rows.iter().filter_map(|row| {
        let (ratio, comparable) = row.effectivity()?;
        comparable.then_some((row, ratio))
    });
    let (judged, bounds): (Vec<_>, Vec<_>) =
        compared.partition(|(row, _)| row.corrected().is_some());
    let estimated = rows.iter().filter(|row| row.estimated.is_some()).count();
    let outside: Vec<String> = judged
        .iter()
        .filter(|(_, e)| !WINDOW.contains(e))
        .map(|(row, e)| format!("{} {}, {e:.2}", row.group, row.name))
        .collect();
    let mut notes = vec![format!(
        "estimated: the error bar of the value, relative to the same scale as the error; ratio: estimated over true error, in brackets if the true \
         error is below three algebraic error bars or below the uncertainty of the estimate: so small an error is due to chance cancellation between \
         cells. corrected: the value minus its estimated error; gain: the factor by which its error is smaller. {estimated} rows have an estimate; of \
         the estimates with a sign, {} ratios are not in brackets, {} of them between {} and {}.",
        judged.len(),
        judged.len() - outside.len(),
        WINDOW.start,
        WINDOW.end,
    )];
    if !outside.is_empty() {
        notes.push(format!("Ratios outside: {}.", outside.join("; ")));
    }
    if let Some(largest) = bounds.iter().map(|(_, e)| *e).reduce(f64::max) {
        let smallest = bounds.iter().fold(largest, |m, (_, e)| m.min(*e));
        notes.push(format!(
            "Error bars without a sign are upper bounds: {} ratios from {smallest:.2} to {largest:.2}.",
            bounds.len()
        ));
    }
    notes
}

/// Panics unless the effectivity of a row can be judged and is within [`WINDOW`].
#[cfg(test)]
pub fn assert_effective(row: &Row) {
    let ratio = row.effectivity();
    assert!(
        ratio.is_some_and(|(ratio, comparable)| comparable && WINDOW.contains(&ratio)),
        "{}: error {:.3e}, ratio {ratio:?}",
        row.name,
        row.error
    );
}

#[cfg(test)]
mod tests {
    use super::super::estimated::Estimated;
    use super::super::row::{Basis, Cost};
    use super::*;

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

    #[test]
    fn a_row_with_an_estimate_has_ratio_and_gain() {
        let row = row(Estimated::signed(0.08));
        let (ratio, comparable) = row.effectivity().expect("the row has an estimate");
        assert!((ratio - 0.8).abs() < 1e-12 && comparable);
        assert!((row.bar().expect("the row has an estimate") - 0.02).abs() < 1e-12);
        let (corrected, gain) = row.corrected().expect("the row has an estimate");
        assert!((corrected - 2.02).abs() < 1e-12 && (gain - 5.0).abs() < 1e-9);
        assert_eq!(notes(&[row]).len(), 1);
    }

    #[test]
    fn errors_below_the_limit_are_not_compared_and_ratios_outside_the_window_are_listed() {
        let small_error = row(Estimated {
            error: None,
            bar: 0.5,
            limit: 0.2,
        });
        assert_eq!(
            small_error.effectivity().map(|(_, comparable)| comparable),
            Some(false)
        );
        assert_eq!(small_error.corrected(), None);
        assert_eq!(notes(std::slice::from_ref(&small_error)).len(), 1);
        let bound = Estimated {
            limit: 0.0,
            ..small_error.estimated.expect("the row has an estimate")
        };
        assert!(notes(&[row(bound)])[1].contains("1 ratios from 5.00 to 5.00"));
        let wide = row(Estimated::signed(0.5));
        assert!(notes(&[wide])[1].contains("A drag, 5.00"));
    }
}
