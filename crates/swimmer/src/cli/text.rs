//! Text on the terminal: results on stdout, messages on stderr.

use std::io::{IsTerminal, Write};

use clap::builder::styling::AnsiColor;
use swimmer::models::ErrorEstimate;

/// Width of the column of labels.
const LABEL_WIDTH: usize = 24;

/// What stands behind a value whose error is not estimated.
pub const NO_ESTIMATE: &str = "(no error estimate)";

/// Largest ratio of an uncertainty to its value that is printed; beyond it the value is noise.
const LARGEST_RATIO: f64 = 1.0;

/// Components of a vector below this ratio to its size are rounding errors and printed as zero.
const ROUNDING: f64 = 1e-12;

/// Writes one line to stderr. A closed stderr is no error.
pub fn message(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Writes a warning to stderr.
pub fn warn(text: &str) {
    coloured_message("warning:", AnsiColor::Yellow, text);
}

/// Writes an error to stderr.
pub fn error_message(text: &str) {
    coloured_message("error:", AnsiColor::Red, text);
}

/// Writes a line to stderr whose first word is coloured where colours are wanted: on a terminal,
/// unless the environment variable `NO_COLOR` is set (<https://no-color.org>) or `TERM` is `dumb`.
fn coloured_message(word: &str, colour: AnsiColor, text: &str) {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let is_dumb = std::env::var_os("TERM").is_some_and(|terminal| terminal == "dumb");
    match std::io::stderr().is_terminal() && !is_set("NO_COLOR") && !is_dumb {
        true => {
            let style = colour.on_default().bold();
            message(&format!("{style}{word}{style:#} {text}"));
        }
        false => message(&format!("{word} {text}")),
    }
}

/// Writes a finished text to stdout. A closed stdout is no error: its reader has what it wanted.
pub fn print(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// One line with a label and a value.
pub fn entry(label: &str, value: &str) -> String {
    format!("{label:<LABEL_WIDTH$}{value}\n")
}

/// A vector whose components are known up to rounding errors of numbers of this size.
pub fn vector(components: [f64; 3], size: f64) -> String {
    let words = components.map(|x| match x.abs() <= ROUNDING * size {
        true => "0".to_owned(),
        false => format!("{x:.4e}"),
    });
    format!("({})", words.join(", "))
}

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

/// A ratio in percent, with two significant digits.
pub fn percent(ratio: f64) -> String {
    format!("{} %", two_digits(100.0 * ratio))
}

/// An absolute error and, in brackets, its ratio to `reference`, without the bracket if the error
/// is larger.
pub fn error(absolute: f64, reference: f64) -> String {
    if absolute > 0.0 && absolute <= LARGEST_RATIO * reference {
        format!("{absolute:.1e} ({})", percent(absolute / reference))
    } else if absolute > 0.0 {
        format!("{absolute:.1e}")
    } else {
        "0".to_owned()
    }
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
    // As many decimals as show two digits of the uncertainty; doubles have no more than 15.
    let decimals = (1 - magnitude(uncertainty)).clamp(0, 15) as usize;
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

/// Error estimates by source and their sum, absolute and relative to `reference`, one line each.
///
/// `name` is the name of the reference.
pub fn error_estimates(
    label: &str,
    estimate: &ErrorEstimate,
    reference: f64,
    name: &str,
) -> String {
    let mut text = entry(label, &format!("absolute (relative to {name})"));
    let mut missing = Vec::new();
    for (source, estimated) in estimate.sources() {
        match estimated {
            Some(absolute) => {
                text += &entry(&format!("  {source}"), &error(absolute, reference));
            }
            None => missing.push(source),
        }
    }
    text += &entry("  sum", &error(estimate.total(), reference));
    if !missing.is_empty() {
        text += &entry("  not estimated", &missing.join(", "));
    }
    text
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
    fn ratios_have_two_significant_digits() {
        for (ratio, text) in [
            (0.0, "0 %"),
            (0.002_56, "0.26 %"),
            (0.099_6, "10 %"),
            (2.5, "250 %"),
            (1e-9, "1.0e-7 %"),
        ] {
            assert_eq!(percent(ratio), text);
        }
        assert_eq!(error(3.2e-3, 0.16), "3.2e-3 (2.0 %)");
        assert_eq!(error(3.2e-3, 0.0), "3.2e-3");
        assert_eq!(error(3.2e-3, 1e-17), "3.2e-3");
    }

    #[test]
    fn rounding_errors_of_a_vector_are_printed_as_zero() {
        assert_eq!(
            vector([1.2257e-2, -3e-33, 0.0], 1.2257e-2),
            "(1.2257e-2, 0, 0)"
        );
    }
}
