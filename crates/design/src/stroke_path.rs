//! Closed curves of shapes, sampled at quadrature points.

use std::f64::consts::{PI, TAU};

use nalgebra::DMatrix;
use scene::PhaseSpan;

use super::quadrature::{GaussRule, POINTS};

/// A curve of shapes at the quadrature points of successive intervals.
#[derive(Clone, Debug)]
pub struct SampledPath {
    /// Width of each interval; their sum is the duration.
    pub widths: Vec<f64>,
    /// Values of the varying joints, `POINTS` times per interval.
    pub shapes: Vec<Vec<f64>>,
    /// Rates of the varying joints.
    pub rates: Vec<Vec<f64>>,
}

/// Number of intervals per phase span of a gait.
const INTERVALS_PER_SPAN: usize = 16;

impl SampledPath {
    /// The path of a polygon with these corners and times, see [`StrokeCurve::Polygon`].
    pub fn from_polygon(corners: &[Vec<f64>], times: &[f64]) -> Self {
        Self::from_sides(corners, times, INTERVALS_PER_SPAN)
    }

    /// The path of a polygon with this number of intervals per side.
    pub fn from_sides(corners: &[Vec<f64>], times: &[f64], intervals: usize) -> Self {
        let mut path = Self::empty();
        for (side, from) in corners.iter().enumerate() {
            let to = &corners[(side + 1) % corners.len()];
            let duration = times[side + 1] - times[side];
            let ends = || from.iter().zip(to);
            path.append(duration, intervals, |s| {
                (
                    ends().map(|(a, b)| a + s * (b - a)).collect(),
                    ends().map(|(a, b)| (b - a) / duration).collect(),
                )
            });
        }
        path
    }

    /// The path of a gait, of which the joints `variables` are taken.
    pub fn from_spans(spans: impl Iterator<Item = PhaseSpan>, variables: &[usize]) -> Self {
        let mut path = Self::empty();
        let chosen = |all: Vec<f64>| variables.iter().map(|&k| all[k]).collect::<Vec<f64>>();
        for span in spans {
            path.append(span.duration, INTERVALS_PER_SPAN, |s| {
                (chosen(span.shape(s)), chosen(span.rates(s)))
            });
        }
        path
    }

    fn empty() -> Self {
        Self {
            widths: Vec::new(),
            shapes: Vec::new(),
            rates: Vec::new(),
        }
    }

    /// Appends a part in equal intervals; `at` gives shape and rates at a share of it.
    fn append(
        &mut self,
        duration: f64,
        intervals: usize,
        at: impl Fn(f64) -> (Vec<f64>, Vec<f64>),
    ) {
        let rule = GaussRule::new();
        for part in 0..intervals {
            self.widths.push(duration / intervals as f64);
            for node in rule.nodes {
                let (shape, rates) = at((part as f64 + node) / intervals as f64);
                self.shapes.push(shape);
                self.rates.push(rates);
            }
        }
    }
}

/// The functions of which the joint values of a stroke are sums, of the time `u` from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub enum Series {
    /// Fourier series: `1`, and `cos 2πku`, `sin 2πku` for `k` up to the number of terms.
    Closed {
        /// Number of harmonics.
        terms: usize,
    },
    /// `sin πku` added to the shape at the start, where the curve may have a corner.
    FromStart {
        /// Number of sines.
        terms: usize,
        /// The shape at the start and at the end.
        start: Vec<f64>,
    },
}

/// Intervals per term: the term of highest order then has 12 quadrature points per oscillation.
const INTERVALS_PER_TERM: usize = 4;

impl Series {
    /// A closed series, or one from a start.
    pub(super) fn new(terms: usize, start: Option<&[f64]>) -> Self {
        match start {
            Some(start) => Self::FromStart {
                terms,
                start: start.to_vec(),
            },
            None => Self::Closed { terms },
        }
    }

    /// Number of functions per joint.
    pub fn functions(&self) -> usize {
        match self {
            Self::Closed { terms } => 2 * terms + 1,
            Self::FromStart { terms, .. } => *terms,
        }
    }

    /// Number of terms.
    pub fn terms(&self) -> usize {
        match self {
            Self::Closed { terms } | Self::FromStart { terms, .. } => *terms,
        }
    }

    /// The same series with another number of terms.
    #[must_use]
    pub fn with_terms(&self, terms: usize) -> Self {
        let start = match self {
            Self::Closed { .. } => None,
            Self::FromStart { start, .. } => Some(&start[..]),
        };
        Self::new(terms, start)
    }

    /// What the value of a joint is without its functions.
    fn offset(&self, joint: usize) -> f64 {
        match self {
            Self::Closed { .. } => 0.0,
            Self::FromStart { start, .. } => start[joint],
        }
    }

    /// Angle per time of function `k`, and whether it is a cosine.
    fn angle(&self, k: usize) -> (f64, bool) {
        match self {
            Self::Closed { .. } => (TAU * k.div_ceil(2) as f64, k > 0 && k.is_multiple_of(2)),
            Self::FromStart { .. } => (PI * (k + 1) as f64, false),
        }
    }

    /// Value and derivative of function `k` at the time `u`.
    pub fn function(&self, k: usize, u: f64) -> (f64, f64) {
        if matches!(self, Self::Closed { .. }) && k == 0 {
            return (1.0, 0.0);
        }
        let (angle, is_cosine) = self.angle(k);
        let (sin, cos) = (angle * u).sin_cos();
        match is_cosine {
            true => (cos, -angle * sin),
            false => (sin, angle * cos),
        }
    }

    /// Shape at a time; `coefficients` are those of the first joint, then of the next.
    pub fn shape(&self, coefficients: &[f64], u: f64) -> Vec<f64> {
        let values: Vec<f64> = (0..self.functions())
            .map(|k| self.function(k, u).0)
            .collect();
        (coefficients.chunks(self.functions()).enumerate())
            .map(|(joint, c)| {
                let sum: f64 = c.iter().zip(&values).map(|(c, f)| c * f).sum();
                self.offset(joint) + sum
            })
            .collect()
    }

    /// Coefficients of the same curve for a series with more terms.
    pub fn extended(&self, coefficients: &[f64], finer: &Self) -> Vec<f64> {
        let joints = coefficients.chunks(self.functions());
        joints
            .flat_map(|c| {
                let padding = finer.functions() - c.len();
                c.iter().copied().chain(std::iter::repeat_n(0.0, padding))
            })
            .collect()
    }
}

/// A closed curve of shapes, a function of the time from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub enum StrokeCurve {
    /// A sum of functions.
    Series {
        /// The functions.
        series: Series,
        /// Coefficients, those of the first joint first.
        coefficients: Vec<f64>,
    },
    /// Straight lines.
    Polygon {
        /// The corners; the first one follows on the last one.
        corners: Vec<Vec<f64>>,
        /// Times at which the corners are reached, the first one being 0, and 1.
        times: Vec<f64>,
    },
}

impl StrokeCurve {
    /// Shape at a time.
    pub fn shape(&self, u: f64) -> Vec<f64> {
        match self {
            Self::Series {
                series,
                coefficients,
            } => series.shape(coefficients, u),
            Self::Polygon { corners, times } => {
                let side = side(corners, times, u);
                let (from, to) = (&corners[side], &corners[(side + 1) % corners.len()]);
                let share = (u - times[side]) / (times[side + 1] - times[side]);
                let ends = from.iter().zip(to);
                ends.map(|(a, b)| a + share * (b - a)).collect()
            }
        }
    }

    /// Derivative of the shape with respect to the time.
    pub fn rates(&self, u: f64) -> Vec<f64> {
        match self {
            Self::Series {
                series,
                coefficients,
            } => {
                let slopes: Vec<f64> = (0..series.functions())
                    .map(|k| series.function(k, u).1)
                    .collect();
                let joints = coefficients.chunks(series.functions());
                joints
                    .map(|c| c.iter().zip(&slopes).map(|(c, f)| c * f).sum())
                    .collect()
            }
            Self::Polygon { corners, times } => {
                let side = side(corners, times, u);
                let ends = corners[side]
                    .iter()
                    .zip(&corners[(side + 1) % corners.len()]);
                let duration = times[side + 1] - times[side];
                ends.map(|(a, b)| (b - a) / duration).collect()
            }
        }
    }

    /// Number of terms of a series, or of corners.
    pub fn terms(&self) -> usize {
        match self {
            Self::Series { series, .. } => series.terms(),
            Self::Polygon { corners, .. } => corners.len(),
        }
    }
}

/// Number of the side of a polygon that is passed at a time.
fn side(corners: &[Vec<f64>], times: &[f64], u: f64) -> usize {
    let sides = 1..corners.len();
    sides.rev().find(|&k| times[k] <= u).unwrap_or(0)
}

/// The functions of a series at all quadrature points of a period of one.
#[derive(Clone, Debug)]
pub struct SampledSeries {
    /// The series.
    pub series: Series,
    /// Number of intervals.
    pub intervals: usize,
    /// Functions at the points, one row per point.
    pub values: DMatrix<f64>,
    /// Their derivatives in time.
    pub slopes: DMatrix<f64>,
}

impl SampledSeries {
    /// Samples a series.
    pub fn new(series: Series) -> Self {
        let rule = GaussRule::new();
        let intervals = INTERVALS_PER_TERM * series.terms().max(4);
        let points = intervals * POINTS;
        let at = |row: usize, k: usize| {
            let node = rule.nodes[row % POINTS];
            series.function(k, ((row / POINTS) as f64 + node) / intervals as f64)
        };
        let functions = series.functions();
        Self {
            values: DMatrix::from_fn(points, functions, |row, k| at(row, k).0),
            slopes: DMatrix::from_fn(points, functions, |row, k| at(row, k).1),
            intervals,
            series,
        }
    }

    /// The curve with these coefficients.
    pub fn path(&self, coefficients: &[f64]) -> SampledPath {
        let functions = self.series.functions();
        let joints = coefficients.len() / functions;
        let c = DMatrix::from_column_slice(functions, joints, coefficients);
        let (shapes, rates) = (&self.values * &c, &self.slopes * &c);
        let row = |m: &DMatrix<f64>, point: usize| m.row(point).iter().copied().collect::<Vec<_>>();
        let points = 0..self.values.nrows();
        SampledPath {
            widths: vec![1.0 / self.intervals as f64; self.intervals],
            shapes: (points.clone())
                .map(|point| {
                    let mut shape = row(&shapes, point);
                    for (joint, value) in shape.iter_mut().enumerate() {
                        *value += self.series.offset(joint);
                    }
                    shape
                })
                .collect(),
            rates: points.map(|point| row(&rates, point)).collect(),
        }
    }

    /// Derivatives with respect to the coefficients from those with respect to shapes and rates.
    pub fn to_coefficients(&self, of_shapes: &DMatrix<f64>, of_rates: &DMatrix<f64>) -> Vec<f64> {
        let sum = self.values.tr_mul(of_shapes) + self.slopes.tr_mul(of_rates);
        sum.as_slice().to_vec()
    }
}
