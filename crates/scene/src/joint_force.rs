//! Forces on joints that oscillate in time.

use crate::shape_path::Sine;

/// A force on a passive joint, a torque for joints that turn:
/// `amplitude sin(2 π order t / period + phase)` at the time `t`.
///
/// It acts in addition to the constant part, [`rigid::PassiveDrive::force`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointForce {
    /// The joint, with amplitude, phase and order; a positive force increases the value.
    pub sine: Sine,
    /// Period of a term of the order one.
    pub period: f64,
}

impl JointForce {
    /// The force at a time.
    pub fn at(&self, time: f64) -> f64 {
        self.sine.at(time / self.period)
    }
}
