//! Signed discretisation errors of one solution.

use std::ops::{Deref, DerefMut};

pub(crate) use axisymmetric::REGULARISATION_FACTOR;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::response::{BodySolution, Response};

/// Estimated discretisation error of one solution, in the scene's units.
///
/// Errors have signs, because errors along a stroke partly cancel, as the velocities do. They are
/// what [`correct`](crate::InstantaneousSolution::correct) subtracts: computed minus exact. An
/// error dereferences to its [`Response`], as a solution does.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscretisationError {
    /// Errors of motion and loads.
    pub response: Response,
    /// What is uncertain about the estimate: error bars of the corrected solution.
    pub uncertainty: Uncertainty,
}

/// Uncertainty of an estimated discretisation error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Uncertainty {
    /// Relative uncertainty of all parts of the estimate.
    pub relative: f64,
    /// Uncertainty of velocities, in which the errors around different bodies do not cancel.
    pub velocity: f64,
    /// Uncertainty of angular velocities, in which the errors around different bodies do not
    /// cancel.
    #[serde(default)]
    pub angular_velocity: f64,
    /// Uncertainty of forces, in which errors of motion and slip may cancel.
    #[serde(default)]
    pub force: f64,
    /// Uncertainty of torques beside bodies whose volume changes.
    #[serde(default)]
    pub torque: f64,
    /// Uncertainty of errors of the power that may cancel with others: of straight facets and slip.
    #[serde(default)]
    pub power: f64,
}

impl Deref for DiscretisationError {
    type Target = Response;
    fn deref(&self) -> &Response {
        &self.response
    }
}

impl DerefMut for DiscretisationError {
    fn deref_mut(&mut self) -> &mut Response {
        &mut self.response
    }
}

impl DiscretisationError {
    /// The difference of the responses to the same query, such as computed minus corrected.
    pub fn between(computed: &Response, corrected: &Response, uncertainty: Uncertainty) -> Self {
        Self {
            response: computed - corrected,
            uncertainty,
        }
    }

    /// The sum of `terms`, each times its factor, such as an interpolation between configurations
    /// of one arrangement.
    ///
    /// Of the relative uncertainties the largest counts, those of velocities are summed like the
    /// errors. None without terms.
    pub fn combination<'a>(terms: impl IntoIterator<Item = (f64, &'a Self)>) -> Option<Self> {
        let scaled = |(factor, error): (f64, &Self)| Self {
            response: &error.response * factor,
            uncertainty: Uncertainty {
                relative: error.uncertainty.relative,
                velocity: error.uncertainty.velocity * factor,
                angular_velocity: error.uncertainty.angular_velocity * factor,
                force: error.uncertainty.force * factor,
                torque: error.uncertainty.torque * factor,
                power: error.uncertainty.power * factor,
            },
        };
        let plus = |sum: Self, term: Self| Self {
            response: sum.response + &term.response,
            uncertainty: Uncertainty {
                relative: sum.uncertainty.relative.max(term.uncertainty.relative),
                velocity: sum.uncertainty.velocity + term.uncertainty.velocity,
                angular_velocity: sum.uncertainty.angular_velocity
                    + term.uncertainty.angular_velocity,
                force: sum.uncertainty.force + term.uncertainty.force,
                torque: sum.uncertainty.torque + term.uncertainty.torque,
                power: sum.uncertainty.power + term.uncertainty.power,
            },
        };
        let mut sum = terms.into_iter().map(scaled).reduce(plus)?;
        let Uncertainty {
            relative: _,
            velocity,
            angular_velocity,
            force,
            torque,
            power,
        } = &mut sum.uncertainty;
        for uncertainty in [velocity, angular_velocity, force, torque, power] {
            *uncertainty = uncertainty.max(0.0);
        }
        Some(sum)
    }

    /// Error bar of the corrected velocities of all bodies.
    pub fn velocity_error_bar(&self) -> f64 {
        (self.uncertainty.relative * self.velocity()).hypot(self.uncertainty.velocity)
    }

    /// Error bar of the corrected angular velocities of all bodies.
    pub fn angular_velocity_error_bar(&self) -> f64 {
        (self.uncertainty.relative * self.largest(|body| body.angular_velocity))
            .hypot(self.uncertainty.angular_velocity)
    }

    /// Magnitude of the largest error of the velocity of a body.
    pub fn velocity(&self) -> f64 {
        self.largest(|body| body.velocity)
    }

    /// Error bar of the corrected power, if the correction of the power is `removed`.
    pub fn power_error_bar(&self, removed: f64) -> f64 {
        (self.uncertainty.relative * removed.abs()).max(self.uncertainty.power)
    }

    /// Error bar of the corrected forces of all bodies, and of those that hold bodies.
    pub fn force_error_bar(&self) -> f64 {
        let of_holding = self.holding.iter().map(|load| load.force.norm());
        let largest = of_holding.fold(self.largest(|body| body.force), f64::max);
        (self.uncertainty.relative * largest).hypot(self.uncertainty.force)
    }

    /// Error bar of the corrected torques of all bodies, and of those that hold bodies.
    ///
    /// A torque is the power of a rotation of one body, so its error does not cancel with others as
    /// that of a velocity of linked bodies does.
    pub fn torque_error_bar(&self) -> f64 {
        let of_holding = self.holding.iter().map(|load| load.torque.norm());
        let largest = of_holding.fold(self.largest(|body| body.torque), f64::max);
        (self.uncertainty.relative * largest).hypot(self.uncertainty.torque)
    }

    fn largest(&self, of: fn(&BodySolution) -> Vector3<f64>) -> f64 {
        (self.bodies.iter()).fold(0.0, |largest, body| largest.max(of(body).norm()))
    }
}
