//! Numbers as text, with the digits that their uncertainty leaves.

use swimmer::{Outcome, Scene};

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
        return format!("{} {NO_ESTIMATE}", with_digits(value, DIGITS));
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

/// Number of significant digits of a number whose uncertainty is not known.
const DIGITS: i32 = 8;

/// Largest number of significant digits of a number in a table; JSON has all of them.
const MAX_DIGITS: i32 = 10;

/// A number up to the second digit of its uncertainty, of ten significant digits at most; with
/// eight of them if the uncertainty is zero, that is, not known.
///
/// Zero for a number that is not larger than its uncertainty or than `rounding`.
pub fn significant(value: f64, uncertainty: f64, rounding: f64) -> String {
    if value.abs() <= uncertainty.max(rounding) {
        return "0".to_owned();
    }
    let first = magnitude(value.abs());
    let digits = match uncertainty > 0.0 {
        true => (first - magnitude(uncertainty) + 2).clamp(2, MAX_DIGITS),
        false => DIGITS,
    };
    with_digits(value, digits)
}

/// A number with this many significant digits, of one that is very large or small with its power
/// of ten.
pub fn with_digits(value: f64, digits: i32) -> String {
    match magnitude(value.abs()) {
        _ if value == 0.0 => "0".to_owned(),
        first @ -4..6 => format!("{value:.*}", (digits - 1 - first).max(0) as usize),
        _ => format!("{value:.*e}", (digits - 1).max(0) as usize),
    }
}

/// A vector in brackets whose components have the digits of [`significant`].
pub fn significant_vector(vector: [f64; 3], uncertainty: f64, rounding: f64) -> String {
    let words = vector.map(|x| significant(x, uncertainty, rounding));
    format!("({})", words.join(", "))
}

/// A vector with the error bar of each component, or with the words that it has none.
pub fn vector_with_bar(vector: [f64; 3], bar: Option<f64>, rounding: f64) -> String {
    let numbers = significant_vector(vector, bar.unwrap_or(0.0), rounding);
    match bar {
        Some(bar) => format!("{numbers} +- {}", two_digits(bar)),
        None => format!("{numbers} {NO_ESTIMATE}"),
    }
}

/// Angles in radians that are rounding: some hundred products of rotations.
pub const ANGLE_ROUNDING: f64 = 1e-13;

/// What a run says about its tolerance, for both the terminal and the page.
///
/// `model.tolerance` limits the error of the integration alone if the model does not control its
/// own; then the whole error bar may be larger, which is said. So is a bar that is within the
/// tolerance relative to the path of the surfaces, but not to the net displacement.
pub fn tolerance_statement(outcome: &Outcome, tolerance: f64) -> String {
    let bars = &outcome.error_estimate;
    let (bar, reference) = (bars.total(), outcome.reference_displacement());
    let whole = match reference > 0.0 {
        true => format!("the whole error bar is {}", percent(bar / reference)),
        // Nothing moves.
        false => format!("the whole error bar is {}", two_digits(bar)),
    };
    if !outcome.tolerance_met {
        return format!("the tolerance {tolerance:e} is not met");
    }
    if bar <= tolerance * reference {
        return format!("the tolerance {tolerance:e} is met");
    }
    let arc = outcome.net_arc.max(outcome.longest_arc);
    if bar <= outcome.allowed_error {
        return format!(
            "the tolerance {tolerance:e} is met relative to the path {} of the surfaces by \
             rotation; relative to the net displacement, {whole}",
            two_digits(arc)
        );
    }
    match bars.integration.unwrap_or(0.0) <= tolerance * reference.max(arc) {
        true => format!(
            "the integration meets the tolerance {tolerance:e}, which does not limit the errors of \
             the model: {whole}"
        ),
        false => format!(
            "the integration adds at most a tenth to the errors of the model, which the tolerance \
             {tolerance:e} does not limit: {whole}"
        ),
    }
}

/// What a run says about a gait that is not closed: the shape at the end, and the rigid part of the
/// motion; none for a closed one.
pub fn open_gait(scene: &Scene, outcome: &Outcome) -> Option<[String; 2]> {
    let change = outcome.shape_change(scene)?;
    let joints: Vec<String> = (change.joints.iter())
        .map(|(joint, by)| format!("{} {by:+.4}", scene.joint_label(&[*joint])))
        .collect();
    let shape = format!(
        "another one at the end ({}); the net displacement contains this change",
        joints.join(", ")
    );
    let bar = outcome.error_estimate.total();
    let moved = significant_vector(change.displacement.into(), bar, outcome.rounding());
    let bar = outcome.rotation_error.total();
    let turned = significant_vector(change.rotation.into(), bar, ANGLE_ROUNDING);
    let body = &scene.bodies()[change.body].name;
    let rigid = format!("displacement {moved}, rotation {turned} rad of the frame of '{body}'");
    Some([shape, rigid])
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

/// The solves of a run, and what was looked up in tables.
pub fn solve_count(outcome: &Outcome) -> String {
    let solves = count(outcome.model_solves(), "solve");
    match outcome.lookups {
        0 => solves,
        lookups => format!("{solves}, {} in tables", count(lookups, "look-up")),
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
            (0.5, 0.0, "0.50000000 (no error estimate)"),
            (3.123_409_372_587_438, 0.0, "3.1234094 (no error estimate)"),
        ] {
            assert_eq!(with_uncertainty(value, uncertainty), text);
        }
    }

    #[test]
    fn numbers_of_vectors_have_the_digits_of_their_common_uncertainty() {
        for (value, uncertainty, rounding, text) in [
            (0.160_718_3, 0.000_412, 0.0, "0.16072"),
            (1.5e-5, 2e-9, 0.0, "1.50000e-5"),
            (-0.000_15, 2e-9, 0.0, "-0.0001500000"),
            (1e-13, 0.0, 0.0, "1.0000000e-13"),
            (1e-13, 0.0, 1e-12, "0"),
            (1e-13, 2e-13, 0.0, "0"),
            (0.3, 1e-17, 0.0, "0.3000000000"),
            (123_456.0, 2.0e4, 0.0, "123456"),
            (1_234_567.0, 2.0e4, 0.0, "1.235e6"),
            (-0.0, 0.0, 0.0, "0"),
        ] {
            assert_eq!(significant(value, uncertainty, rounding), text);
        }
        assert_eq!(
            significant_vector([0.5, -2e-7, 1e-9], 1e-8, 0.0),
            "(0.500000000, -2.00e-7, 0)"
        );
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
