//! Phase spans: the phases of all cycles of a gait, one after the other.

use std::f64::consts::TAU;

use rigid::{DerivativeBounds, ValueBounds};

use crate::shape_path::{ShapePath, Sine};

/// One phase of one cycle, with the shape as a function of the parameter `s` from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PhaseSpan {
    /// Number of the phase span over all cycles, from zero.
    pub number: usize,
    /// Number of the phase within its cycle, from zero.
    pub phase: usize,
    /// The joints that change their values.
    pub joints: Vec<usize>,
    /// Values of the joints at `s` = 0.
    pub from: Vec<f64>,
    /// Values of the joints at `s` = 1.
    pub to: Vec<f64>,
    /// Time at `s` = 0.
    pub start: f64,
    /// Duration.
    pub duration: f64,
    /// Mean values of the joints, about which those with sines oscillate.
    pub(crate) means: Vec<f64>,
    pub(crate) path: ShapePath,
}

/// Number of parts of a phase span at whose ends the shape is evaluated where its range is needed.
const RANGE_PARTS: usize = 64;

impl PhaseSpan {
    /// Values of the joints at `s` in [0, 1]; outside, those at the nearer end.
    pub fn shape(&self, s: f64) -> Vec<f64> {
        let s = s.clamp(0.0, 1.0);
        // In this form a constant value is reproduced to the last bit.
        let linear = || {
            let ends = self.from.iter().zip(&self.to);
            ends.map(|(a, b)| a + s * (b - a)).collect::<Vec<f64>>()
        };
        match &self.path {
            ShapePath::Linear(_) => linear(),
            ShapePath::Spline(path) => {
                let mut shape = self.from.clone();
                path.enter_values(s, &mut shape);
                shape
            }
            ShapePath::Harmonic { sines, turns, span } => {
                let mut shape = self.means.clone();
                let periods = span.0 + s * (span.1 - span.0);
                for sine in sines {
                    shape[sine.joint] += sine.at(periods);
                }
                for (joint, change) in turns {
                    shape[*joint] += change * periods;
                }
                shape
            }
            ShapePath::Own(path) => {
                let mut shape = self.from.clone();
                path.enter_values(s, &mut shape);
                shape
            }
        }
    }

    /// Rates of change of the values in time at `s` in [0, 1]; outside, those at the nearer end.
    pub fn rates(&self, s: f64) -> Vec<f64> {
        let s = s.clamp(0.0, 1.0);
        let linear = || {
            let ends = self.from.iter().zip(&self.to);
            ends.map(|(a, b)| (b - a) / self.duration)
                .collect::<Vec<f64>>()
        };
        match &self.path {
            ShapePath::Linear(_) => linear(),
            ShapePath::Spline(path) => {
                let mut rates = vec![0.0; self.from.len()];
                path.enter_rates(s, &mut rates);
                rates
            }
            ShapePath::Harmonic { sines, turns, span } => {
                let width = span.1 - span.0;
                let mut rates = vec![0.0; self.means.len()];
                for sine in sines {
                    rates[sine.joint] +=
                        sine.derivative(span.0 + s * width) * width / self.duration;
                }
                for (joint, change) in turns {
                    rates[*joint] += change * width / self.duration;
                }
                rates
            }
            ShapePath::Own(path) => {
                let mut rates = vec![0.0; self.from.len()];
                path.enter_derivatives(s, 1.0 / self.duration, &mut rates);
                rates
            }
        }
    }

    /// Intervals that contain the values of the joints along the phase span.
    ///
    /// Those of linear paths are sharp. Others are too wide by at most 3e-5 of the largest second
    /// derivative with respect to `s`, for a sine 8e-5 of the amplitude times the order squared.
    /// Second derivatives of paths of a program are measured.
    pub fn ranges(&self) -> Vec<(f64, f64)> {
        let mut ranges: Vec<(f64, f64)> = (self.from.iter().zip(&self.to))
            .map(|(&a, &b)| (a.min(b), a.max(b)))
            .collect();
        if self.is_linear() {
            return ranges;
        }
        for k in 1..RANGE_PARTS {
            let shape = self.shape(k as f64 / RANGE_PARTS as f64);
            for (range, length) in ranges.iter_mut().zip(shape) {
                *range = (range.0.min(length), range.1.max(length));
            }
        }
        for (joint, bend) in self.bends() {
            // Between two points a function leaves the interval of its values there by at most an
            // eighth of the largest second derivative times the square of their distance.
            let excess = 0.125 * bend / (RANGE_PARTS * RANGE_PARTS) as f64;
            ranges[joint] = (ranges[joint].0 - excess, ranges[joint].1 + excess);
        }
        ranges
    }

    /// Largest second derivatives with respect to `s`, one for each joint.
    ///
    /// Those of paths of a program are measured: twice the largest difference of 64 rates.
    pub fn second_derivatives(&self) -> Vec<f64> {
        let mut largest = vec![0.0; self.from.len()];
        for (joint, bend) in self.bends() {
            largest[joint] += bend;
        }
        largest
    }

    /// Bounds on the values of the joints between two positions, with derivatives with respect to
    /// the part of this interval that is over.
    ///
    /// `second_derivatives` are those of [`PhaseSpan::second_derivatives`].
    pub fn value_bounds(
        &self,
        second_derivatives: &[f64],
        (from, to): (f64, f64),
    ) -> Vec<ValueBounds> {
        let (middle, width) = (0.5 * (from + to), to - from);
        let values = self.shape(middle).into_iter().zip(self.rates(middle));
        let bound = |((value, rate), bend): ((f64, f64), &f64)| {
            let second = width * width * bend;
            let first = width * (rate * self.duration).abs() + 0.5 * second;
            ValueBounds {
                size: value.abs() + 0.5 * first,
                derivatives: DerivativeBounds { first, second },
            }
        };
        values.zip(second_derivatives).map(bound).collect()
    }

    /// Terms of the largest second derivatives with respect to `s`.
    fn bends(&self) -> Vec<(usize, f64)> {
        match &self.path {
            ShapePath::Linear(_) => Vec::new(),
            ShapePath::Spline(path) => path.second_derivatives().collect(),
            ShapePath::Harmonic { sines, span, .. } => {
                let angle = |sine: &Sine| TAU * f64::from(sine.order) * (span.1 - span.0);
                let bend = |sine: &Sine| (sine.joint, sine.amplitude * angle(sine).powi(2));
                sines.iter().map(bend).collect()
            }
            ShapePath::Own(_) => self.measured_bends(),
        }
    }

    /// Second derivatives with respect to `s`, from differences of the rates.
    fn measured_bends(&self) -> Vec<(usize, f64)> {
        let rates: Vec<_> = (0..=RANGE_PARTS)
            .map(|k| self.rates(k as f64 / RANGE_PARTS as f64))
            .collect();
        let bend = |joint: usize| {
            let changes = rates.windows(2).map(|pair| pair[1][joint] - pair[0][joint]);
            let largest = changes.fold(0.0, |largest: f64, change| largest.max(change.abs()));
            // Between the points it can be larger; twice as large would be a path with corners.
            2.0 * largest * self.duration * RANGE_PARTS as f64
        };
        self.joints
            .iter()
            .map(|&joint| (joint, bend(joint)))
            .collect()
    }

    /// The position at which a step between two others is divided: the middle or, along a table,
    /// the row next to it, because a spline is smoother between its rows than at them.
    pub fn middle(&self, ends: (f64, f64)) -> f64 {
        let row = match &self.path {
            ShapePath::Spline(path) => path.middle(ends),
            _ => None,
        };
        row.unwrap_or(0.5 * (ends.0 + ends.1))
    }

    /// Joints with the largest distance of their values between two positions from a polynomial
    /// through a few points, for a path through the rows of a table; empty for other paths.
    ///
    /// The polynomial has the degree eight and nine Chebyshev points. What deviates from it, such
    /// as an outlier in one of a thousand rows, a step with a few points does not see. It is zero
    /// between two rows. Cost: ten operations per row and joint.
    pub fn roughness(&self, ends: (f64, f64)) -> Vec<(usize, f64)> {
        match &self.path {
            ShapePath::Spline(path) => path.roughness(ends),
            _ => Vec::new(),
        }
    }

    /// Whether the path is a program's ([`JointPath`](crate::JointPath)).
    pub fn is_own_path(&self) -> bool {
        matches!(self.path, ShapePath::Own(_))
    }

    /// Whether the shape is linear in `s`.
    pub fn is_linear(&self) -> bool {
        matches!(self.path, ShapePath::Linear(_))
    }

    /// Time at `s`.
    pub fn time(&self, s: f64) -> f64 {
        self.start + s * self.duration
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::gait::{Gait, Phase, spans};
    use crate::spline_path::{SplineColumn, SplinePath, Splines};

    #[test]
    fn sines_of_several_orders_close_and_their_ranges_contain_them() {
        let sine = |joint, amplitude, phase, order| Sine {
            joint,
            amplitude,
            phase,
            order,
        };
        let sines = vec![
            sine(0, 2.0, 0.3, 1),
            sine(0, 0.5, 1.0, 3),
            sine(2, 1.0, 2.0, 2),
        ];
        let gait = Gait::harmonic(2, sines, 6.0);
        let initial = [8.0, 5.0, 7.0];
        let all: Vec<PhaseSpan> = spans(&gait, &initial).unwrap().collect();
        assert_eq!(all.len(), 8);
        assert_eq!(all[0].joints, [0, 2]);
        assert_eq!(gait.duration(), 12.0);
        for (a, b) in initial.iter().zip(&all[7].to) {
            assert!((a - b).abs() < 1e-14);
        }
        for span in &all {
            let ranges = span.ranges();
            for k in 0..=1000 {
                let s = f64::from(k) / 1000.0;
                let shape = span.shape(s);
                assert_eq!(shape[1], 5.0);
                for (length, range) in shape.iter().zip(&ranges) {
                    assert!((range.0..=range.1).contains(length));
                }
                // Central differences with d = 1e-5: rounding 1e-15 / d and d^2 times the third
                // derivative.
                let d = 1e-5;
                let s = s.clamp(d, 1.0 - d);
                let [before, after] = [span.shape(s - d), span.shape(s + d)];
                for (joint, rate) in span.rates(s).iter().enumerate() {
                    let expected = (after[joint] - before[joint]) / (2.0 * d * span.duration);
                    assert!((rate - expected).abs() < 1e-8, "{rate} {expected}");
                }
            }
            // The true extremes are at most 8e-5 of the amplitudes times the orders squared away.
            let shape: Vec<f64> = (0..=1000)
                .map(|k| span.shape(1e-3 * f64::from(k))[0])
                .collect();
            let (low, high) = shape
                .iter()
                .fold((f64::MAX, f64::MIN), |(low, high), &length| {
                    (low.min(length), high.max(length))
                });
            let allowed = 8e-5 * (2.0 + 0.5 * 9.0);
            assert!(low - ranges[0].0 < allowed && ranges[0].1 - high < allowed);
        }
    }

    /// Outside of [0, 1] a span is that of the nearer end, on all kinds of paths.
    #[test]
    fn a_span_ends_at_its_ends() {
        let sine = Sine {
            joint: 0,
            amplitude: 2.0,
            phase: 0.3,
            order: 1,
        };
        let splines = Splines {
            times: vec![0.0, 1.5, 2.0],
            columns: vec![SplineColumn {
                joint: 0,
                values: vec![8.0, 4.0, 3.0],
                bends: vec![1.0, -2.0, 0.5],
            }],
        };
        let path = SplinePath::new(Arc::new(splines), 0, 2);
        let spline = Phase {
            path: ShapePath::Spline(path),
            duration: 2.0,
        };
        let gaits = [
            Gait::harmonic(1, vec![sine], 6.0),
            Gait {
                cycles: 1,
                phases: vec![spline],
            },
        ];
        for gait in gaits {
            let span = spans(&gait, &[8.0]).unwrap().next().unwrap();
            assert!(span.rates(0.0)[0] != 0.0 && span.rates(1.0)[0] != 0.0);
            for (outside, end) in [(-0.5, 0.0), (1.0 + f64::EPSILON, 1.0), (7.0, 1.0)] {
                assert_eq!(span.shape(outside), span.shape(end));
                assert_eq!(span.rates(outside), span.rates(end));
            }
            assert!(span.shape(f64::NAN)[0].is_nan());
        }
    }
}
