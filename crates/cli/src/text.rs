//! Text on the terminal: results on stdout, messages on stderr.

use std::fmt::Display;
use std::io::{ErrorKind, IsTerminal, Write};

use clap::builder::styling::AnsiColor;
use nalgebra::Vector3;
use pictures::numbers::{ANGLE_ROUNDING, LARGEST_RATIO, significant_vector};
pub use pictures::numbers::{
    NO_ESTIMATE, count, duration, open_gait, percent, rounded, significant, solve_count,
    tolerance_statement, two_digits, with_uncertainty,
};
use swimmer::models::ErrorEstimate;

use super::error::CliError;

/// Width of the column of labels.
const LABEL_WIDTH: usize = 24;

/// Components of a vector below this ratio to its size are rounding errors and printed as zero.
const ROUNDING: f64 = 1e-12;

/// A text whose control characters, except ends of lines and tabulators, are written as in JSON.
///
/// Names come from files, and a terminal would obey what they contain. Marks that change the
/// direction of writing count as well, because they make a name look like another one.
pub fn printable(text: &str) -> String {
    let is_hidden = |c: char| {
        matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
            || c.is_control() && !matches!(c, '\n' | '\t')
    };
    let mut printable = String::with_capacity(text.len());
    for c in text.chars() {
        match is_hidden(c) {
            true => printable += &format!("\\u{:04x}", u32::from(c)),
            false => printable.push(c),
        }
    }
    printable
}

/// Writes one line to stderr. A closed stderr is no error.
pub fn message(line: &str) {
    write_message(&printable(line));
}

fn write_message(line: &str) {
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
            write_message(&format!("{style}{word}{style:#} {}", printable(text)));
        }
        false => message(&format!("{word} {text}")),
    }
}

/// Writes a finished text to stdout. A closed stdout is no error: its reader has what it wanted.
///
/// # Errors
/// [`CliError::Output`], such as on a full disk.
pub fn print(text: &str) -> Result<(), CliError> {
    check_printed(std::io::stdout().write_all(printable(text).as_bytes()))
}

/// Checks that what was written to stdout has arrived there. A closed pipe is no error.
pub fn check_printed(written: std::io::Result<()>) -> Result<(), CliError> {
    match written.and_then(|()| std::io::stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Output(error)),
        _ => Ok(()),
    }
}

/// One line with a label and a value.
pub fn entry(label: &str, value: impl Display) -> String {
    format!("{label:<LABEL_WIDTH$}{value}\n")
}

/// A value with its uncertainty, or with two digits where none is known.
pub fn with_bar(value: f64, uncertainty: Option<f64>) -> String {
    match uncertainty {
        Some(uncertainty) => with_uncertainty(value, uncertainty),
        None => two_digits(value),
    }
}

/// One line with a label and a value with its uncertainty.
pub fn measured(label: &str, value: f64, uncertainty: f64) -> String {
    entry(label, with_uncertainty(value, uncertainty))
}

/// One line with a label and a rotation vector in radians, up to the digits of its error bar.
pub fn rotation_entry(label: &str, rotation: &Vector3<f64>, bar: f64) -> String {
    let vector = significant_vector((*rotation).into(), bar, ANGLE_ROUNDING);
    entry(label, format!("{vector} rad"))
}

/// The factors of a product, such as the sizes of a grid.
pub fn product(factors: &[usize]) -> String {
    let factors: Vec<String> = factors.iter().map(ToString::to_string).collect();
    factors.join(" x ")
}

/// A vector whose components are known up to rounding errors of numbers of this size.
pub fn vector(components: [f64; 3], size: f64) -> String {
    let words = components.map(|x| match x.abs() <= ROUNDING * size {
        true => "0".to_owned(),
        false => format!("{x:.4e}"),
    });
    format!("({})", words.join(", "))
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

/// Error estimates by source and their sum, absolute and relative to `reference`, one line each.
///
/// `name` is the name of the reference.
pub fn error_estimates(
    label: &str,
    estimate: &ErrorEstimate,
    reference: f64,
    name: &str,
) -> String {
    let mut text = entry(label, format!("absolute (relative to {name})"));
    let mut missing = Vec::new();
    for (source, estimated) in estimate.sources() {
        match estimated {
            Some(absolute) => {
                text += &entry(&format!("  {source}"), error(absolute, reference));
            }
            None => missing.push(source),
        }
    }
    let sum = estimate.estimated();
    text += &entry(
        "  sum",
        sum.map_or(NO_ESTIMATE.to_owned(), |sum| error(sum, reference)),
    );
    if !missing.is_empty() {
        text += &entry("  not estimated", missing.join(", "));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn control_characters_of_a_name_do_not_reach_the_terminal() {
        assert_eq!(
            printable("a\u{1b}[2Jb\r\u{9b}\u{202e}é\n\t"),
            "a\\u001b[2Jb\\u000d\\u009b\\u202eé\n\t"
        );
    }

    #[test]
    fn rounding_errors_of_a_vector_are_printed_as_zero() {
        assert_eq!(
            vector([1.2257e-2, -3e-33, 0.0], 1.2257e-2),
            "(1.2257e-2, 0, 0)"
        );
    }
}
