//! Shapes (values of joints) as functions of time along a phase.

use std::f64::consts::TAU;

use crate::joint_path::OwnPath;

/// Values of the joints along a phase, as functions of the part `s` of the phase that is over.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapePath {
    /// Joints change their values at constant rates to the given ones; all others keep theirs.
    ///
    /// Without joints all values are constant.
    Linear(Vec<(usize, f64)>),
    /// Cubic polynomials, such as the pieces of a spline.
    Cubic(Vec<CubicLength>),
    /// Part of a period of sums of sines.
    Harmonic {
        /// The terms of all joints.
        sines: Vec<Sine>,
        /// Begin and end of the phase, in periods.
        span: (f64, f64),
    },
    /// A path that a program defines.
    Own(OwnPath),
}

/// One term of a periodic value: `amplitude sin(2 π order t / T + phase)` with the period `T`.
///
/// A joint may have several terms. Their mean is such that the value at `t = 0` is the initial
/// one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// The joint.
    pub joint: usize,
    /// Amplitude.
    pub amplitude: f64,
    /// Phase angle at `t = 0`, in radians.
    pub phase: f64,
    /// Number of oscillations in a period.
    pub order: u32,
}

/// Value of a joint along a phase, a cubic polynomial in `s`:
///
/// ```text
/// begin + (end - begin) s + square (s^2 - s) + cube (s^3 - s)
/// ```
///
/// It begins with the value at the end of the phase before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicLength {
    /// The joint.
    pub joint: usize,
    /// Value at the end.
    pub end: f64,
    /// Coefficient of the second degree.
    pub square: f64,
    /// Coefficient of the third degree.
    pub cube: f64,
}

impl ShapePath {
    /// The joints whose values change, each once, in the order of their first terms.
    pub fn joints(&self) -> Vec<usize> {
        let mut joints = Vec::new();
        let mut add = |joint: usize| {
            if !joints.contains(&joint) {
                joints.push(joint);
            }
        };
        match self {
            Self::Linear(changes) => changes.iter().for_each(|(joint, _)| add(*joint)),
            Self::Cubic(pieces) => pieces.iter().for_each(|piece| add(piece.joint)),
            Self::Harmonic { sines, .. } => sines.iter().for_each(|sine| add(sine.joint)),
            Self::Own(path) => path.0.joints().into_iter().for_each(add),
        }
        joints
    }
}

impl Sine {
    pub(crate) fn angle(&self, periods: f64) -> f64 {
        TAU * f64::from(self.order) * periods + self.phase
    }

    /// The term after a number of periods.
    pub(crate) fn at(&self, periods: f64) -> f64 {
        self.amplitude * self.angle(periods).sin()
    }

    /// Derivative with respect to the number of periods.
    pub(crate) fn derivative(&self, periods: f64) -> f64 {
        self.amplitude * TAU * f64::from(self.order) * self.angle(periods).cos()
    }
}
