//! Checks of what callers pass in.

use crate::FemError;

/// An error unless the array `what` has the `expected` length and every entry is finite.
pub(crate) fn check_array(
    what: &'static str,
    values: &[f64],
    expected: usize,
) -> Result<(), FemError> {
    if values.len() != expected {
        return Err(FemError::Length {
            what,
            found: values.len(),
            expected,
        });
    }
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(FemError::NotFinite { what, index }),
        None => Ok(()),
    }
}
