//! Comparisons that say why.

/// Asserts that an error is at most its bound, and returns their ratio.
///
/// # Panics
/// If `|error|` is larger than the bound or one of them is not a number, with the reason of the
/// bound.
#[track_caller]
pub fn within(error: f64, bound: f64, why: impl std::fmt::Display) -> f64 {
    let error = error.abs();
    assert!(
        error <= bound,
        "error {error:e} above the bound {bound:e}: {why}"
    );
    error / bound
}

/// Asserts that all parts occur in a text; `what` says which text of a table it is.
///
/// # Panics
/// If a part is missing.
#[track_caller]
pub fn contains(what: impl std::fmt::Debug, text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{what:?}: {part:?} is not in: {text}");
    }
}

#[cfg(test)]
mod tests {
    use super::within;

    #[test]
    #[should_panic(expected = "error 2e0 above the bound 1e0: the reason")]
    fn a_missed_bound_says_why_it_is_the_bound() {
        assert_eq!(within(-1.0, 2.0, "half of it"), 0.5);
        within(2.0, 1.0, "the reason");
    }

    #[test]
    #[should_panic(expected = "error NaN")]
    fn nan_is_not_within_any_bound() {
        within(f64::NAN, f64::INFINITY, "NaN");
    }
}
