//! Errors that the program estimates, compared with the true ones.

use swimmer::models::{AccumulatedError, ErrorEstimate, InstantaneousSolution};

/// Estimated error of a value, in the unit of the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimated {
    /// Estimate of computed minus exact, if its sign is known.
    pub error: Option<f64>,
    /// The error bar.
    pub bar: f64,
    /// True errors below this limit are not compared with the estimate.
    ///
    /// It is three times the algebraic error bar, or the uncertainty of the estimate if that is
    /// larger: a smaller error is due to chance cancellation between cells.
    pub limit: f64,
}

/// Range in which the ratio of estimated to true error should be.
pub const WINDOW: std::ops::Range<f64> = 0.7..1.4;

/// Smallest true error, in algebraic error bars, that is attributed to the discretisation.
const ALGEBRAIC: f64 = 3.0;

impl Estimated {
    /// Estimate for the velocity of a body along x.
    pub fn velocity(solution: &InstantaneousSolution, body: usize) -> Self {
        let error = solution.mesh_error.as_ref();
        Self::new(
            error.map(|e| (e.bodies[body].velocity.x, e.uncertainty.velocity)),
            &solution.error_estimate,
        )
    }

    /// Estimate for the force of a body along x, if there is one.
    pub fn force(solution: &InstantaneousSolution, body: usize) -> Option<Self> {
        let errors = solution.mesh_error.as_ref()?;
        Some(Self::signed(errors.bodies.get(body)?.force.x))
    }

    /// Estimate for the displacement along x of the first body, which does not rotate.
    pub fn displacement(accumulated: Option<&AccumulatedError>, bars: &ErrorEstimate) -> Self {
        Self::new(
            accumulated.map(|sum| (sum.displacement[0].x, sum.uncertainty)),
            bars,
        )
    }

    fn new(by_mesh: Option<(f64, f64)>, bars: &ErrorEstimate) -> Self {
        let algebraic = ALGEBRAIC * bars.algebraic.unwrap_or(0.0);
        let (error, uncertainty) = by_mesh.unzip();
        Self {
            error,
            bar: bars.total(),
            limit: algebraic.max(uncertainty.unwrap_or(0.0)),
        }
    }

    /// Error bar that is meant as an upper bound.
    pub fn bound(bar: f64) -> Self {
        Self {
            error: None,
            bar,
            limit: 0.0,
        }
    }

    /// Error estimate with a sign, and with no lower limit for the comparison.
    pub fn signed(error: f64) -> Self {
        Self {
            error: Some(error),
            bar: error.abs(),
            limit: 0.0,
        }
    }

    /// Estimate for a function of the value with this derivative.
    pub fn times(self, derivative: f64) -> Self {
        Self {
            error: self.error.map(|error| derivative * error),
            bar: derivative.abs() * self.bar,
            limit: derivative.abs() * self.limit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_change_the_sign_of_errors_but_not_of_bars() {
        let estimated = Estimated::signed(0.1).times(-2.0);
        assert_eq!((estimated.error, estimated.bar), (Some(-0.2), 0.2));
    }
}
