//! Numbers as text, with the digits that their uncertainty leaves.

use swimmer::Outcome;

/// What stands behind a value whose error is not estimated.
pub const NO_ESTIMATE: &str = "(no error estimate)";

/// Largest ratio of an uncertainty to its value that is printed; beyond it the value is noise.
pub const LARGEST_RATIO: f64 = 1.0;

/// A positive number with two significant digits.
pub fn two_digits(x: f64) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    match magnitude(x) {
        exponent @ -4..4 => format!("{x:.*}", (1 - exponent).max(0) as usize),
        _ => format!("{x:.1e}"),
    }
}

/// The decimal exponent of a number rounded to two significant digits.
fn magnitude(x: f64) -> i32 {
    let text = format!("{x:.1e}");
    let exponent = text.split_once('e').and_then(|(_, e)| e.parse().ok());
    exponent.unwrap_or(0)
}

/// Number of decimals that show two digits of a positive uncertainty; doubles have at most 15.
pub fn decimals(uncertainty: f64) -> usize {
    (1 - magnitude(uncertainty)).clamp(0, 15) as usize
}

/// The value as it is printed with a number of decimals, without the sign of a negative zero:
/// `-1e-9` is then printed as `0.00000` and not as `-0.00000`.
pub fn rounded(value: f64, decimals: usize) -> f64 {
    let printed = format!("{value:.decimals$}").parse().unwrap_or(value);
    printed + 0.0
}

/// A ratio in percent, with two significant digits.
pub fn percent(ratio: f64) -> String {
    format!("{} %", two_digits(100.0 * ratio))
}

/// A value with its uncertainty, absolute and relative: `0.16072 +- 0.00041 (0.26 %)`.
///
/// The ratio is left out if the uncertainty is larger than the value.
pub fn with_uncertainty(value: f64, uncertainty: f64) -> String {
    if uncertainty <= 0.0 {
        return format!("{value} {NO_ESTIMATE}");
    }
    let largest = magnitude(value.abs().max(uncertainty));
    let (scale, suffix) = match largest {
        -4..6 => (1.0, String::new()),
        _ => (10_f64.powi(-largest), format!("e{largest}")),
    };
    let (value, uncertainty) = (value * scale, uncertainty * scale);
    let decimals = decimals(uncertainty);
    let uncertainty_text = match decimals {
        0..=8 => format!("{uncertainty:.decimals$}"),
        _ => format!("{uncertainty:.1e}"),
    };
    let both = format!("{value:.decimals$} +- {uncertainty_text}");
    let both = match suffix.is_empty() {
        true => both,
        false => format!("({both}){suffix}"),
    };
    match uncertainty > LARGEST_RATIO * value.abs() {
        true => both,
        false => format!("{both} ({})", percent(uncertainty / value.abs())),
    }
}

/// What a run says about its tolerance, for both the terminal and the page.
///
/// `model.tolerance` limits the error of the integration alone if the model does not control its
/// own; then the whole error bar may be larger, which is said.
pub fn tolerance_statement(outcome: &Outcome, tolerance: f64) -> String {
    let bar = outcome.error_estimate.total();
    if !outcome.tolerance_met {
        return format!("the tolerance {tolerance:e} is not met");
    }
    match bar <= outcome.allowed_error {
        true => format!("the tolerance {tolerance:e} is met"),
        false => format!(
            "the integration meets the tolerance {tolerance:e}, which does not limit the errors of \
             the model: the whole error bar is {}",
            percent(tolerance * bar / outcome.allowed_error)
        ),
    }
}

/// A time in the unit that suits its size.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.0} µs", 1e6 * s),
        s if s < 1.0 => format!("{:.0} ms", 1e3 * s),
        s if s < 120.0 => format!("{s:.1} s"),
        s => format!("{:.0} min", s / 60.0),
    }
}

/// A number with its noun, in the plural unless it is one.
pub fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {noun}{plural}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_have_the_digits_that_their_uncertainty_leaves() {
        for (value, uncertainty, text) in [
            (0.160_718_3, 0.000_412, "0.16072 +- 0.00041 (0.26 %)"),
            (0.163_284, 0.003_26, "0.1633 +- 0.0033 (2.0 %)"),
            (0.159_805_340_4, 4.5e-9, "0.1598053404 +- 4.5e-9 (2.8e-6 %)"),
            (1.607_18e-7, 4.12e-10, "(1.6072 +- 0.0041)e-7 (0.26 %)"),
            (0.0, 0.0123, "0.000 +- 0.012"),
            (0.001, 0.25, "0.00 +- 0.25"),
            (0.5, 0.0, "0.5 (no error estimate)"),
        ] {
            assert_eq!(with_uncertainty(value, uncertainty), text);
        }
    }

    #[test]
    fn rounded_numbers_have_no_negative_zero() {
        for (value, decimals, text) in [
            (-1e-9, 5, "0.00000"),
            (-0.4, 0, "0"),
            (-1.6e-5, 5, "-0.00002"),
            (-1.5e15, 1, "-1500000000000000.0"),
            (f64::NAN, 2, "NaN"),
        ] {
            assert_eq!(format!("{:.decimals$}", rounded(value, decimals)), text);
        }
    }
}
