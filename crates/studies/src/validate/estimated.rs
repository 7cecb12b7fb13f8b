//! What the program says about the error of a value.

use swimmer::models::{AccumulatedError, ErrorEstimate, InstantaneousSolution};

/// What the program says about the error of a value, in the unit of the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimated {
    /// Estimated discretisation error that was subtracted, computed minus exact; `None` for methods
    /// without a correction.
    pub removed: Option<f64>,
    /// Error bar of the value.
    pub bar: f64,
}

impl Estimated {
    /// Estimate for the velocity of a body along x.
    pub fn velocity(solution: &InstantaneousSolution, body: usize) -> Self {
        let error = solution.mesh_error.as_ref();
        Self {
            removed: error.map(|error| error.bodies[body].velocity.x),
            bar: solution.error_estimate.total(),
        }
    }

    /// Estimate for the angular velocity of a body about z, if there is one.
    ///
    /// Its bar is the relative uncertainty of the correction, as for forces.
    pub fn angular_velocity(solution: &InstantaneousSolution, body: usize) -> Option<Self> {
        let error = solution.mesh_error.as_ref()?;
        let removed = error.bodies.get(body)?.angular_velocity.z;
        Some(Self {
            removed: Some(removed),
            bar: error.uncertainty.relative * removed.abs(),
        })
    }

    /// Estimate for the force of a body along x, if there is one.
    pub fn force(solution: &InstantaneousSolution, body: usize) -> Option<Self> {
        let error = solution.mesh_error.as_ref()?;
        Some(Self {
            removed: Some(error.bodies.get(body)?.force.x),
            bar: error.force_error_bar(),
        })
    }

    /// Estimate for the displacement along x of the first body, which does not rotate.
    pub fn displacement(accumulated: Option<&AccumulatedError>, bars: &ErrorEstimate) -> Self {
        Self {
            removed: accumulated.map(|sum| sum.displacement[0].x),
            bar: bars.total(),
        }
    }

    /// Error bar of a value that was not corrected.
    pub fn bound(bar: f64) -> Self {
        Self { removed: None, bar }
    }

    /// Estimate for a function of the value with this derivative.
    pub fn times(self, derivative: f64) -> Self {
        Self {
            removed: self.removed.map(|removed| derivative * removed),
            bar: derivative.abs() * self.bar,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_change_the_sign_of_errors_but_not_of_bars() {
        let estimated = Estimated {
            removed: Some(0.1),
            bar: 0.01,
        }
        .times(-2.0);
        assert_eq!((estimated.removed, estimated.bar), (Some(-0.2), 0.02));
    }
}
