//! Requested accuracy of the expansions.

use crate::HydroError;

/// Requested accuracy of a multipole expansion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Accuracy {
    /// Relative error of the resistance: the order is raised until the estimate is below it.
    ///
    /// Between `1e-13`, below which rounding errors dominate, and 1.
    pub tolerance: f64,
    /// Fixed order of all expansions; `None` derives the orders from the gaps and the tolerance.
    pub order: Option<usize>,
}

/// Lowest relative error that can be requested.
const LOWEST_TOLERANCE: f64 = 1e-13;

impl Default for Accuracy {
    /// A tolerance of `1e-8`: convergence is spectral, so the last digits cost little.
    fn default() -> Self {
        Self::relative(1e-8)
    }
}

impl Accuracy {
    /// Checks the tolerance.
    ///
    /// # Errors
    /// [`HydroError::BadTolerance`].
    pub(super) fn check(&self) -> Result<(), HydroError> {
        // The comparison also rejects NaN.
        match (LOWEST_TOLERANCE..=1.0).contains(&self.tolerance) {
            true => Ok(()),
            false => Err(HydroError::BadTolerance {
                tolerance: self.tolerance,
                lowest: LOWEST_TOLERANCE,
            }),
        }
    }

    /// Accuracy given by a relative error of the resistance.
    pub fn relative(tolerance: f64) -> Self {
        Self {
            tolerance,
            order: None,
        }
    }

    /// Accuracy given by a fixed order of all expansions, at least 2; the tolerance does not apply.
    pub fn order(order: usize) -> Self {
        Self {
            tolerance: f64::INFINITY,
            order: Some(order),
        }
    }
}
