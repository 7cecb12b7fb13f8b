//! What the tests of several crates share.
//!
//! A test is then what it checks: scenes come from [`SceneText`], exact values with their accuracy
//! and source from [`exact`], models that are observed or disturbed from [`Recording`], and every
//! comparison with a bound says by [`within`] why it has that bound. Errors are panics with all
//! that is known, since nothing here runs outside of tests.

#![forbid(unsafe_code)]

pub mod exact;
mod recording;
mod runs;
mod scenes;

pub use recording::Recording;
pub use runs::{boxed, forces, run, run_by, solve_at, start, start_by, start_resistance};
pub use scenes::{STROKE, SceneText, chain, pair, planar, three_spheres};

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
