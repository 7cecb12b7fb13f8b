//! Requested accuracy of the expansions.

/// Requested accuracy of a multipole expansion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Accuracy {
    /// Relative error of the resistance: the order is raised until the estimate is below it.
    ///
    /// Values below `1e-13` count as `1e-13`: rounding errors dominate there.
    pub tolerance: f64,
    /// Fixed order of all expansions; `None` derives the orders from the gaps and the tolerance.
    pub order: Option<usize>,
}

impl Default for Accuracy {
    /// A tolerance of `1e-8`: convergence is spectral, so the last digits cost little.
    fn default() -> Self {
        Self::relative(1e-8)
    }
}

impl Accuracy {
    /// Accuracy given by a relative error of the resistance.
    pub fn relative(tolerance: f64) -> Self {
        Self {
            tolerance,
            order: None,
        }
    }

    /// Accuracy given by a fixed order of all expansions, at least 2.
    pub fn order(order: usize) -> Self {
        Self {
            tolerance: f64::INFINITY,
            order: Some(order),
        }
    }
}
