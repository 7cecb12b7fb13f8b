//! Text on the terminal: results on stdout, messages on stderr.

use std::io::Write;

use swimmer::models::ErrorEstimate;
pub use swimmer::output::numbers::{count, duration, percent, two_digits, with_uncertainty};

/// Width of the column of labels.
const LABEL_WIDTH: usize = 24;

/// Writes one line to stderr. A closed stderr is no error.
pub fn message(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// Writes a warning to stderr.
pub fn warn(text: &str) {
    message(&format!("warning: {text}"));
}

/// Writes a finished text to stdout. A closed stdout is no error: its reader has what it wanted.
pub fn print(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// One line with a label and a value.
pub fn entry(label: &str, value: &str) -> String {
    format!("{label:<LABEL_WIDTH$}{value}\n")
}

/// An absolute error and, in brackets, its ratio to `reference`, without the bracket if that is
/// zero.
pub fn error(absolute: f64, reference: f64) -> String {
    if reference > 0.0 && absolute > 0.0 {
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
    }
}
