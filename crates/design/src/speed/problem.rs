//! The largest displacement per time of polygons with a given number of corners.

use models::ShapeGeometry;
use nalgebra::{DMatrix, DVector};

use super::polygon::{TimedPolygon, path, side_energies, to_ends};
use super::rows::SparseRows;
use crate::evaluation::{Evaluation, Problem};
use crate::interior_point::{Minimum, minimise};
use crate::objective::DisplacementMeasure;
use crate::timing::MotionBounds;
use crate::totals::Stroke;

/// Diagonal of the first Hessian of a problem with a bound on the power: a metric that is constant
/// says nothing about a motion of the whole polygon.
const OF_MOTION: f64 = 0.5;

/// What all searches of one scene share.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// Connection and metric.
    pub geometry: &'a ShapeGeometry,
    /// Which displacement counts.
    pub measure: DisplacementMeasure,
    /// Limits of the joints.
    pub limits: &'a [(f64, f64)],
    /// Bounds on rates and power.
    pub bounds: &'a MotionBounds,
    /// The first corner, if it is given.
    pub start: Option<&'a [f64]>,
}

/// The logarithm of period over displacement as a function of corners and times of the sides:
///
/// ```text
/// minimise log(Σ_k t_k) - log |Δ(q)|
///     with |q_(k+1) - q_k|_i <= v_i t_k,   ∫ Δq_k · G Δq_k ds <= P t_k^2,   limits of q
/// ```
///
/// Corners are in units of the ranges of the joints, times in units of the mean time of a side.
pub struct SpeedProblem<'a> {
    task: Task<'a>,
    sides: usize,
    widths: Vec<f64>,
    time: f64,
    rows: SparseRows,
}

impl<'a> SpeedProblem<'a> {
    /// The problem for polygons with as many corners as a first one.
    pub fn new(task: Task<'a>, first: &TimedPolygon) -> Self {
        let sides = first.corners.len();
        let widths: Vec<f64> = task.limits.iter().map(|range| range.1 - range.0).collect();
        let free = sides - usize::from(task.start.is_some());
        let mut problem = Self {
            rows: SparseRows::new(free * widths.len() + sides),
            task,
            sides,
            widths,
            time: first.period() / sides as f64,
        };
        problem.add_limits();
        problem.add_rates();
        problem
    }

    /// The best polygon from a first one strictly inside the limits.
    pub fn solve(
        &self,
        first: &TimedPolygon,
        tolerance: f64,
        max_iterations: usize,
    ) -> Option<(TimedPolygon, Minimum)> {
        let start = self.variables(first);
        let minimum = minimise(self, &self.rows.bounds(), start, tolerance, max_iterations)?;
        Some((self.polygon(&minimum.x), minimum))
    }

    /// Index of the coordinate of a corner; none for a corner that is given.
    fn index(&self, corner: usize, joint: usize) -> Option<usize> {
        let first = usize::from(self.task.start.is_some());
        let corner = (corner % self.sides).checked_sub(first)?;
        Some(corner * self.widths.len() + joint)
    }

    /// Index of the time of a side.
    fn time_index(&self, side: usize) -> usize {
        self.rows.columns() - self.sides + side
    }

    fn add_limits(&mut self) {
        for corner in 0..self.sides {
            for (joint, range) in self.task.limits.iter().enumerate() {
                if let Some(index) = self.index(corner, joint) {
                    let width = self.widths[joint];
                    let bounds = (range.0 / width, range.1 / width);
                    self.rows.push(vec![(index, 1.0)], bounds);
                }
            }
        }
    }

    /// `t_k ± (q_(k+1) - q_k)_i / v_i >= 0`; without a bound on the rate, `t_k >= 0`.
    fn add_rates(&mut self) {
        for side in 0..self.sides {
            for (joint, rate) in self.task.bounds.rates.iter().enumerate() {
                let factor = self.widths[joint] / (rate * self.time);
                for sign in [1.0, -1.0] {
                    let mut row = vec![(self.time_index(side), 1.0)];
                    let mut lower = 0.0;
                    for (corner, coefficient) in [(side + 1, sign * factor), (side, -sign * factor)]
                    {
                        match self.index(corner, joint) {
                            Some(index) => row.push((index, coefficient)),
                            None => {
                                let given = self.task.start.map_or(0.0, |start| start[joint]);
                                lower -= coefficient * given / self.widths[joint];
                            }
                        }
                    }
                    self.rows.push(row, (lower, f64::INFINITY));
                }
            }
        }
    }

    fn polygon(&self, x: &DVector<f64>) -> TimedPolygon {
        let corner = |number: usize| {
            let coordinate = |joint: usize| match (self.index(number, joint), self.task.start) {
                (Some(index), _) => x[index] * self.widths[joint],
                (None, start) => start.map_or(0.0, |start| start[joint]),
            };
            (0..self.widths.len()).map(coordinate).collect()
        };
        TimedPolygon {
            corners: (0..self.sides).map(corner).collect(),
            durations: (0..self.sides)
                .map(|side| x[self.time_index(side)] * self.time)
                .collect(),
        }
    }

    fn variables(&self, polygon: &TimedPolygon) -> DVector<f64> {
        let mut x = DVector::zeros(self.rows.columns());
        for (number, corner) in polygon.corners.iter().enumerate() {
            for (joint, value) in corner.iter().enumerate() {
                if let Some(index) = self.index(number, joint) {
                    x[index] = value / self.widths[joint];
                }
            }
        }
        for (side, duration) in polygon.durations.iter().enumerate() {
            x[self.time_index(side)] = duration / self.time;
        }
        x
    }

    /// `t_k^2 - ∫ Δq · G Δq ds / P` with derivatives.
    fn power(&self, stroke: &Stroke, x: &DVector<f64>) -> (DVector<f64>, DMatrix<f64>) {
        let factor = 1.0 / (self.task.bounds.power * self.time * self.time);
        let energies = side_energies(stroke, self.sides);
        let (_, of_shapes, of_rates) = stroke.dissipation();
        let ends = to_ends(&of_shapes, &of_rates, self.sides);
        let mut slopes = DMatrix::zeros(self.sides, x.len());
        let values = (energies.iter().enumerate()).map(|(side, energy)| {
            let time = x[self.time_index(side)];
            slopes[(side, self.time_index(side))] = 2.0 * time;
            for (end, of_end) in ends.iter().enumerate() {
                for (joint, width) in self.widths.iter().enumerate() {
                    if let Some(index) = self.index(side + end, joint) {
                        let slope = of_end[(side, joint)] / self.sides as f64;
                        slopes[(side, index)] = -factor * width * slope;
                    }
                }
            }
            time * time - factor * energy
        });
        let values = DVector::from_iterator(self.sides, values);
        (values, slopes)
    }
}

impl Problem for SpeedProblem<'_> {
    fn evaluate(&self, x: &DVector<f64>) -> Option<Evaluation> {
        let polygon = self.polygon(x);
        let stroke = Stroke::along(self.task.geometry, &path(&polygon.corners)).ok()?;
        let (displacement, weights) = self.task.measure.of(&stroke.totals);
        if displacement <= 0.0 {
            return None;
        }
        let (of_shapes, of_rates) = stroke.derivatives(&weights);
        let ends = to_ends(&of_shapes, &of_rates, self.sides);
        let mut gradient = DVector::zeros(x.len());
        for side in 0..self.sides {
            gradient[self.time_index(side)] = self.time / polygon.period();
            for (end, of_end) in ends.iter().enumerate() {
                for (joint, width) in self.widths.iter().enumerate() {
                    if let Some(index) = self.index(side + end, joint) {
                        gradient[index] -= width * of_end[(side, joint)] / displacement;
                    }
                }
            }
        }
        let cost = (polygon.period() / displacement).ln();
        let is_finite = cost.is_finite() && gradient.iter().all(|g| g.is_finite());
        let has_power = self.task.bounds.power.is_finite();
        is_finite.then(|| Evaluation {
            cost,
            gradient,
            condition: None,
            positive: has_power.then(|| self.power(&stroke, x)),
        })
    }

    fn rows(&self, x: &DVector<f64>) -> DVector<f64> {
        self.rows.product(x)
    }

    fn weighted_product(&self, weights: &DVector<f64>) -> DMatrix<f64> {
        self.rows.weighted_product(weights)
    }

    fn transposed(&self, values: &DVector<f64>) -> DVector<f64> {
        self.rows.transposed(values)
    }

    /// For bounds on rates alone, of the order of the second derivatives of the displacement over
    /// two neighbouring corners and of the logarithm of the period. With a bound on the power, for
    /// the corners, the Hessian of the logarithm of the length in a constant metric.
    fn first_hessian(&self, x: &DVector<f64>) -> Option<DMatrix<f64>> {
        let times = x.len() - self.sides;
        let diagonal = |k: usize| match k < times {
            true => 1.0,
            false => 1.0 / self.sides as f64,
        };
        let mut hessian = DMatrix::from_diagonal(&DVector::from_fn(x.len(), |k, _| diagonal(k)));
        if !self.task.bounds.power.is_finite() {
            return Some(hessian);
        }
        hessian
            .view_mut((0, 0), (times, times))
            .fill_diagonal(OF_MOTION);
        let stroke = Stroke::along(self.task.geometry, &path(&self.polygon(x).corners)).ok()?;
        let (metric, energy) = (stroke.mean_metric(), stroke.totals.energy);
        let joints = self.widths.len();
        let pairs = (0..joints).flat_map(|i| (0..joints).map(move |j| (i, j)));
        for (i, j) in pairs {
            let scaled = self.widths[i] * self.widths[j] * metric[(i, j)];
            let stiffness = scaled * self.sides as f64 / energy;
            for side in 0..self.sides {
                for (a, b, sign) in [(0, 0, 1.0), (0, 1, -1.0), (1, 0, -1.0), (1, 1, 1.0)] {
                    let places = (self.index(side + a, i), self.index(side + b, j));
                    if let (Some(row), Some(column)) = places {
                        hessian[(row, column)] += sign * stiffness;
                    }
                }
            }
        }
        Some(hessian)
    }
}
