//! Checks of the arrays that callers pass in.

use mesh::Vec3;

use crate::FemError;

/// Checks that the array `what` has the `expected` length and that every entry is finite.
pub(crate) fn check_array(
    what: &'static str,
    values: &[f64],
    expected: usize,
) -> Result<(), FemError> {
    check(what, values, expected, |value| value.is_finite())
}

/// Checks that the nodal vectors `what` have the `expected` number and that every component is
/// finite.
pub(crate) fn check_vectors(
    what: &'static str,
    values: &[Vec3],
    expected: usize,
) -> Result<(), FemError> {
    check(what, values, expected, |value| {
        value.iter().all(|component| component.is_finite())
    })
}

fn check<T>(
    what: &'static str,
    values: &[T],
    expected: usize,
    is_finite: impl Fn(&T) -> bool,
) -> Result<(), FemError> {
    check_length(what, values.len(), expected)?;
    match values.iter().position(|value| !is_finite(value)) {
        Some(index) => Err(FemError::NotFinite { what, index }),
        None => Ok(()),
    }
}

/// Checks that an array of the length `found` has the `expected` length.
pub(crate) fn check_length(
    what: &'static str,
    found: usize,
    expected: usize,
) -> Result<(), FemError> {
    if found == expected {
        Ok(())
    } else {
        Err(FemError::Length {
            what,
            found,
            expected,
        })
    }
}
