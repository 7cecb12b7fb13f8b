//! Closed surfaces in several shapes with the same triangles, and the shapes between them.

use std::path::PathBuf;

use nalgebra::Vector3;

use crate::material_motion::{MaterialMotion, MaterialPoint, ShapeCoordinate};
use crate::spline::second_derivatives;

/// Name of the coordinate.
pub(crate) const FRAME: &str = "frame";

/// The shapes of a surface at values of its coordinate, and cubic splines between them.
///
/// Each vertex moves along the natural spline through its positions in the frames, or along the
/// periodic one, after which the first frame follows the last one. Between two frames at the
/// distance `h`, with second derivatives `m_0` and `m_1`, it is at the part `u` at
///
/// ```text
/// X = x_0 + u (x_1 - x_0) + u (u - 1) (a + b (u + 1)),   a = h² m_0 / 2,   b = h² (m_1 - m_0) / 6
/// ```
///
/// With a kept volume `V` it is at `(V / V(X))^(1/3) X` instead, with the volume `V(X)` inside the
/// triangles of the spline.
#[derive(Clone, Debug, PartialEq)]
pub struct Frames {
    /// The files of the frames after the first one, which is that of the body.
    pub(crate) files: Vec<PathBuf>,
    /// Values of the coordinate at the frames; of periodic ones also that of the first frame again.
    pub(crate) at: Vec<f64>,
    pub(crate) is_periodic: bool,
    pub(crate) start: f64,
    /// For each frame, the vertices.
    positions: Vec<Vec<Vector3<f64>>>,
    /// For each frame, second derivatives of the splines of the vertices.
    bends: Vec<Vec<Vector3<f64>>>,
    pub(crate) keeps_volume: bool,
    largest_speed: f64,
}

/// Part of the distance of frames beyond the last one that is rounding of a gait.
const ROUNDING: f64 = 1e-9;

impl Frames {
    /// The splines through the vertices of frames at increasing values.
    pub(crate) fn new(positions: Vec<Vec<Vector3<f64>>>, at: Vec<f64>, is_periodic: bool) -> Self {
        let vertices = positions.first().map_or(0, Vec::len);
        let mut bends = vec![vec![Vector3::zeros(); vertices]; at.len()];
        for vertex in 0..vertices {
            for axis in 0..3 {
                let frame = |k: usize| positions[k % positions.len()][vertex][axis];
                let values: Vec<f64> = (0..at.len()).map(frame).collect();
                let seconds = second_derivatives(&at, &values, is_periodic);
                for (bends, second) in bends.iter_mut().zip(seconds) {
                    bends[vertex][axis] = second;
                }
            }
        }
        let mut frames = Self {
            files: Vec::new(),
            start: at.first().copied().unwrap_or_default(),
            at,
            is_periodic,
            positions,
            bends,
            keeps_volume: false,
            largest_speed: 0.0,
        };
        // The velocity is quadratic between frames, and in the hull of its three Bézier points.
        let mut largest: f64 = 0.0;
        for k in 0..frames.at.len().saturating_sub(1) {
            for vertex in 0..vertices {
                let velocity = |u: f64| frames.spline(vertex, k, u)[1];
                let ends = [velocity(0.0), velocity(1.0)];
                let middle = 2.0 * velocity(0.5) - 0.5 * (ends[0] + ends[1]);
                let points = [ends[0], middle, ends[1]];
                largest = points.iter().map(|v| v.norm()).fold(largest, f64::max);
            }
        }
        frames.largest_speed = largest;
        frames
    }

    /// Position and velocity of a vertex at the part `u` of the interval after a frame.
    fn spline(&self, vertex: usize, interval: usize, u: f64) -> [Vector3<f64>; 2] {
        let next = (interval + 1) % self.positions.len();
        let h = self.at[interval + 1] - self.at[interval];
        let [start, end] = [interval, next].map(|k| self.positions[k][vertex]);
        let [first, second] = [interval, interval + 1].map(|k| self.bends[k][vertex]);
        let (a, b) = (0.5 * h * h * first, h * h / 6.0 * (second - first));
        let change = end - start;
        [
            start + u * change + u * (u - 1.0) * (a + b * (u + 1.0)),
            (change + (2.0 * u - 1.0) * a + (3.0 * u * u - 1.0) * b) / h,
        ]
    }

    /// Values of the coordinate at the first frame and at the end of the last spline.
    fn ends(&self) -> [f64; 2] {
        let end = |at: Option<&f64>| at.copied().unwrap_or(f64::NAN);
        [end(self.at.first()), end(self.at.last())]
    }

    /// The interval between frames with a value of the coordinate, and the part of it before.
    fn place(&self, value: f64) -> (usize, f64) {
        let [first, last] = self.ends();
        let value = match self.is_periodic {
            true => first + (value - first).rem_euclid(last - first),
            false => value,
        };
        let after = self.at.partition_point(|at| *at <= value);
        let interval = after.clamp(1, self.at.len() - 1) - 1;
        let [start, end] = [self.at[interval], self.at[interval + 1]];
        (interval, (value - start) / (end - start))
    }

    fn at_value(&self, vertex: usize, amplitudes: &[f64]) -> [Vector3<f64>; 2] {
        let (interval, u) = self.place(amplitudes.first().copied().unwrap_or(f64::NAN));
        self.spline(vertex, interval, u)
    }
}

impl MaterialMotion for Frames {
    fn coordinates(&self) -> Vec<ShapeCoordinate> {
        let [first, last] = self.ends();
        vec![ShapeCoordinate {
            name: FRAME.to_owned(),
            start: self.start,
            period: self.is_periodic.then_some(last - first),
        }]
    }

    fn position(&self, point: &MaterialPoint, amplitudes: &[f64]) -> Vector3<f64> {
        self.at_value(point.vertex, amplitudes)[0]
    }

    fn velocity(&self, point: &MaterialPoint, amplitudes: &[f64], _: usize) -> Vector3<f64> {
        self.at_value(point.vertex, amplitudes)[1]
    }

    fn largest_speed(&self, _: usize) -> f64 {
        self.largest_speed
    }

    fn problem(&self, amplitudes: &[f64]) -> Option<String> {
        let ([first, last], value) = (self.ends(), amplitudes[0]);
        let beyond = (first - value).max(value - last);
        let is_beyond = !self.is_periodic && beyond > ROUNDING * (last - first);
        is_beyond.then(|| {
            format!(
                "has the value {value} of its coordinate '{FRAME}', and its frames are from \
                 {first} to {last}; stay between them, or use periodic = true"
            )
        })
    }

    fn keeps_volume(&self) -> bool {
        self.keeps_volume
    }
}
