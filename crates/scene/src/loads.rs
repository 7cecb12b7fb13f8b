//! Vectors that oscillate in time, such as magnetic fields, and loads that turn with their bodies.

use nalgebra::{UnitQuaternion, Vector3};

use crate::shape_path::angle;
use crate::words::AxesKind;

/// A vector whose components oscillate in time with one period, each with a phase of its own:
/// `mean + amplitude sin(2 π order t / period + phase)`.
///
/// Amplitudes of equal size with phases that differ by a quarter of a turn rotate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VectorOscillation {
    /// Mean.
    pub mean: Vector3<f64>,
    /// Amplitudes; zero for a constant vector.
    pub amplitude: Vector3<f64>,
    /// Phase angles at `t = 0`, in radians.
    pub phase: Vector3<f64>,
    /// Number of oscillations in a period.
    pub order: u32,
    /// Period of an oscillation of the order one.
    pub period: f64,
}

impl VectorOscillation {
    /// A vector that does not depend on the time.
    pub fn constant(mean: Vector3<f64>) -> Self {
        Self {
            mean,
            amplitude: Vector3::zeros(),
            phase: Vector3::zeros(),
            order: 1,
            period: 1.0,
        }
    }

    /// Whether the vector depends on the time.
    pub fn oscillates(&self) -> bool {
        self.amplitude != Vector3::zeros()
    }

    /// The vector at a time.
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// use std::f64::consts::FRAC_PI_2;
    /// // It rotates about z, from x towards y, once in two units of time.
    /// let rotating = scene::VectorOscillation {
    ///     mean: Vector3::zeros(),
    ///     amplitude: Vector3::new(3.0, 3.0, 0.0),
    ///     phase: Vector3::new(FRAC_PI_2, 0.0, 0.0),
    ///     order: 1,
    ///     period: 2.0,
    /// };
    /// assert!((rotating.at(0.5) - Vector3::new(0.0, 3.0, 0.0)).norm() < 1e-15);
    /// ```
    pub fn at(&self, time: f64) -> Vector3<f64> {
        if !self.oscillates() {
            return self.mean;
        }
        let periods = time / self.period;
        let sine = |phase: f64| angle(self.order, periods, phase).sin();
        self.mean + self.amplitude.component_mul(&self.phase.map(sine))
    }

    /// The integral of the vector from the time zero: a displacement, if it is a velocity.
    pub fn integral(&self, time: f64) -> Vector3<f64> {
        let mean = time * self.mean;
        if !self.oscillates() {
            return mean;
        }
        let [start, end] = [0.0, time / self.period];
        let cosine = |periods: f64| {
            self.phase
                .map(|phase| angle(self.order, periods, phase).cos())
        };
        let frequency = 2.0 * std::f64::consts::PI * f64::from(self.order) / self.period;
        mean + self.amplitude.component_mul(&(cosine(start) - cosine(end))) / frequency
    }

    /// Upper bound of the size of each component.
    pub fn largest(&self) -> Vector3<f64> {
        self.mean.abs() + self.amplitude.abs()
    }
}

/// A force or torque on a body that depends on the time or on the attitude of the body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivingLoad {
    /// The vector at any time, in these axes at the start.
    pub vector: VectorOscillation,
    /// Whether the axes are those of the laboratory or turn with the body.
    pub axes: AxesKind,
}

impl DrivingLoad {
    /// The vector in the laboratory axes, for a body after this rotation from the start.
    pub fn at(&self, time: f64, rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
        match self.axes {
            AxesKind::Laboratory => self.vector.at(time),
            AxesKind::Body => rotation * self.vector.at(time),
        }
    }
}
