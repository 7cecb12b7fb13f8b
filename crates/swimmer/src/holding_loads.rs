//! Loads that hold or drive bodies, integrated and averaged in time.

use models::{ErrorEstimate, HoldingLoad, InstantaneousSolution};
use serde::{Deserialize, Serialize};

/// Loads that hold or drive the bodies whose velocities are given, with error bars: impulses
/// `∫ F dt` and `∫ T dt`, or their means over a time.
///
/// The mean force on a body that holds a swimmer is the opposite of the mean thrust.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[non_exhaustive]
pub struct HoldingLoads {
    /// Force and torque, in the axes of the laboratory, of each body whose velocity is given.
    pub bodies: Vec<HoldingLoad>,
    /// Error bars of the forces.
    pub force_error: ErrorEstimate,
    /// Error bars of the torques.
    pub torque_error: ErrorEstimate,
}

impl HoldingLoads {
    /// The impulses of solutions, each with the time for which it stands; errors of the integration
    /// are not known from one approximation.
    pub(crate) fn impulses<'a>(
        solutions: impl Iterator<Item = (&'a InstantaneousSolution, f64)>,
    ) -> Self {
        let mut sum = Self::default();
        for (solution, time) in solutions {
            sum.accumulate(
                time,
                &Self {
                    bodies: solution.holding.clone(),
                    force_error: solution.force_error,
                    torque_error: solution.torque_error,
                },
            );
        }
        sum
    }

    /// Adds `weight` times other loads of the same bodies.
    pub(crate) fn accumulate(&mut self, weight: f64, other: &Self) {
        if other.bodies.is_empty() {
            return;
        }
        if self.bodies.is_empty() {
            let at_rest = |load: &HoldingLoad| HoldingLoad {
                body: load.body,
                ..HoldingLoad::default()
            };
            self.bodies = other.bodies.iter().map(at_rest).collect();
        }
        for (sum, load) in self.bodies.iter_mut().zip(&other.bodies) {
            sum.force += weight * load.force;
            sum.torque += weight * load.torque;
        }
        self.force_error.accumulate(weight, &other.force_error);
        self.torque_error.accumulate(weight, &other.torque_error);
    }

    /// Sizes of the largest force and of the largest torque.
    pub(crate) fn largest(&self) -> [f64; 2] {
        (self.bodies.iter()).fold([0.0; 2], |[force, torque]: [f64; 2], load| {
            [force.max(load.force.norm()), torque.max(load.torque.norm())]
        })
    }

    /// Differences from other loads of the same bodies; their error bars have no meaning.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        let mut difference = self.clone();
        difference.accumulate(-1.0, other);
        difference
    }

    /// Largest differences of the forces and of the torques on a body.
    pub(crate) fn largest_differences(&self, other: &Self) -> [f64; 2] {
        self.minus(other).largest()
    }

    /// The means of impulses over a time.
    pub(crate) fn over(&self, time: f64) -> Self {
        let mut means = Self::default();
        means.accumulate(1.0 / time, self);
        means
    }
}
