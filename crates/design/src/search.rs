//! The best stroke of one series from one start.

use models::ShapeGeometry;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::evaluation::{Bounds, Evaluation, Problem};
use super::interior_point::{Minimum, minimise};
use super::objective::Objective;
use super::stroke_path::{SampledSeries, Series};
use super::totals::{Stroke, StrokeTotals};

/// Predicted decrease at which the starts are compared.
const COMPARE_DECREASE: f64 = 1e-3;

/// Number of iterations in which the starts are compared; those to a good stroke take about 30.
const COMPARE_ITERATIONS: usize = 60;

/// Largest number of iterations of a refined search, which takes 10 to 150.
const MAX_ITERATIONS: usize = 400;

/// Number of times between the quadrature points at which limits are checked.
const CHECKS_PER_TERM: usize = 200;

/// An objective as a function of the coefficients of a series.
pub struct StrokeProblem<'a> {
    geometry: &'a ShapeGeometry,
    objective: &'a dyn Objective,
    sampled: SampledSeries,
    limits: &'a [(f64, f64)],
    /// Widths of the ranges of the joints, by which coefficients and rows are scaled.
    widths: Vec<f64>,
}

impl<'a> StrokeProblem<'a> {
    /// The problem for a series.
    pub fn new(
        geometry: &'a ShapeGeometry,
        objective: &'a dyn Objective,
        series: Series,
        limits: &'a [(f64, f64)],
    ) -> Self {
        Self {
            geometry,
            objective,
            limits,
            widths: limits.iter().map(|r| r.1 - r.0).collect(),
            sampled: SampledSeries::new(series),
        }
    }

    /// The series.
    pub fn series(&self) -> &Series {
        &self.sampled.series
    }

    /// The best strokes from several starts.
    pub fn compared(&self, starts: &[Vec<f64>]) -> Vec<(Vec<f64>, Minimum)> {
        (starts.par_iter())
            .filter_map(|start| {
                let start = inside(self.series(), &self.sized(start), self.limits)?;
                self.solve(&start, self.limits, COMPARE_DECREASE, COMPARE_ITERATIONS)
            })
            .filter(|(_, minimum)| minimum.violation < COMPARE_DECREASE)
            .collect()
    }

    /// The stroke scaled to meet the condition of the objective, whose value is taken as
    /// proportional to the square of the size.
    fn sized(&self, coefficients: &[f64]) -> Vec<f64> {
        const ROUNDS: usize = 4;
        let functions = self.series().functions();
        let has_mean = matches!(self.series(), Series::Closed { .. });
        let mut coefficients = coefficients.to_vec();
        for _ in 0..ROUNDS {
            let stroke = self.stroke(&coefficients);
            let condition = stroke.and_then(|stroke| self.objective.condition(&stroke.totals));
            let Some(excess) = condition.filter(|excess| *excess > -1.0) else {
                break;
            };
            // A step that is too long would leave the table.
            let factor = (1.0 + excess).powf(-0.5).clamp(0.5, 1.5);
            let mut larger = coefficients.clone();
            for c in larger.chunks_mut(functions) {
                let varying = c[usize::from(has_mean)..].iter_mut();
                varying.for_each(|c| *c *= factor);
            }
            if self.stroke(&larger).is_none() {
                break;
            }
            coefficients = larger;
        }
        coefficients
    }

    /// The best stroke whose whole curve is inside the limits.
    ///
    /// The search keeps them at the quadrature points; where the curve leaves them between two
    /// points, they are narrowed by that much and the search is repeated.
    pub fn solved_inside(&self, start: &[f64], tolerance: f64) -> Option<(Vec<f64>, Minimum)> {
        const ROUNDS: usize = 10;
        let mut narrowed = self.limits.to_vec();
        let mut coefficients = start.to_vec();
        for round in 0..ROUNDS {
            // Ten per cent more than the excess. The factor grows, because the curve may oscillate
            // between the points.
            let factor = 1.1 + 0.5 * round as f64;
            let inner = inside(self.series(), &coefficients, &narrowed)?;
            let (found, minimum) = self.solve(&inner, &narrowed, tolerance, MAX_ITERATIONS)?;
            let ranges = ranges(self.series(), &found);
            let mut is_inside = true;
            for ((narrowed, limit), range) in narrowed.iter_mut().zip(self.limits).zip(&ranges) {
                if range.0 < limit.0 {
                    narrowed.0 += factor * (limit.0 - range.0);
                    is_inside = false;
                }
                if range.1 > limit.1 {
                    narrowed.1 -= factor * (range.1 - limit.1);
                    is_inside = false;
                }
            }
            if is_inside {
                return Some((found, minimum));
            }
            coefficients = found;
        }
        None
    }

    /// The best stroke from one with these coefficients, inside `limits`.
    fn solve(
        &self,
        coefficients: &[f64],
        limits: &[(f64, f64)],
        tolerance: f64,
        max_iterations: usize,
    ) -> Option<(Vec<f64>, Minimum)> {
        let offset = self.sampled.path(&vec![0.0; coefficients.len()]).shapes;
        let (points, joints) = (offset.len(), self.widths.len());
        let bound = |of: fn(&(f64, f64)) -> f64| {
            DVector::from_fn(points * joints, |row, _| {
                let (joint, point) = (row / points, row % points);
                (of(&limits[joint]) - offset[point][joint]) / self.widths[joint]
            })
        };
        let bounds = Bounds {
            lower: bound(|range| range.0),
            upper: bound(|range| range.1),
        };
        let minimum = minimise(
            self,
            &bounds,
            self.scaled(coefficients, |c, width| c / width),
            tolerance,
            max_iterations,
        )?;
        Some((self.coefficients(&minimum.x), minimum))
    }

    /// The stroke with these coefficients.
    pub fn stroke(&self, coefficients: &[f64]) -> Option<Stroke> {
        Stroke::along(self.geometry, &self.sampled.path(coefficients)).ok()
    }

    fn coefficients(&self, x: &DVector<f64>) -> Vec<f64> {
        self.scaled(x.as_slice(), |x, width| x * width)
            .as_slice()
            .to_vec()
    }

    /// Coefficients changed by the width of their joint.
    fn scaled(&self, values: &[f64], by: impl Fn(f64, f64) -> f64) -> DVector<f64> {
        let functions = self.series().functions();
        DVector::from_fn(values.len(), |k, _| {
            by(values[k], self.widths[k / functions])
        })
    }

    fn gradient(&self, stroke: &Stroke, weights: &StrokeTotals) -> DVector<f64> {
        let (of_shapes, of_rates) = stroke.derivatives(weights);
        let gradient = self.sampled.to_coefficients(&of_shapes, &of_rates);
        self.scaled(&gradient, |g, width| g * width)
    }
}

impl Problem for StrokeProblem<'_> {
    fn evaluate(&self, x: &DVector<f64>) -> Option<Evaluation> {
        let stroke = self.stroke(&self.coefficients(x))?;
        let (objective, totals) = (self.objective, &stroke.totals);
        let of_condition = |value: f64| {
            let weights = objective.condition_derivatives(totals);
            (value, self.gradient(&stroke, &weights))
        };
        let evaluation = Evaluation {
            cost: objective.cost(totals),
            gradient: self.gradient(&stroke, &objective.cost_derivatives(totals)),
            condition: objective.condition(totals).map(of_condition),
            positive: None,
        };
        let is_finite = evaluation.cost.is_finite()
            && evaluation.gradient.iter().all(|g| g.is_finite())
            && evaluation
                .condition
                .as_ref()
                .is_none_or(|(value, _)| value.is_finite());
        is_finite.then_some(evaluation)
    }

    fn rows(&self, x: &DVector<f64>) -> DVector<f64> {
        let (functions, joints) = (self.sampled.series.functions(), self.widths.len());
        let x = DMatrix::from_column_slice(functions, joints, x.as_slice());
        let rows = &self.sampled.values * x;
        DVector::from_column_slice(rows.as_slice())
    }

    fn weighted_product(&self, weights: &DVector<f64>) -> DMatrix<f64> {
        let values = &self.sampled.values;
        let (points, functions) = values.shape();
        let joints = self.widths.len();
        let mut product = DMatrix::zeros(functions * joints, functions * joints);
        for joint in 0..joints {
            let mut weighted = values.clone();
            for (mut row, weight) in weighted
                .row_iter_mut()
                .zip(weights.rows(joint * points, points).iter())
            {
                row *= *weight;
            }
            let at = joint * functions;
            product
                .view_mut((at, at), (functions, functions))
                .copy_from(&values.tr_mul(&weighted));
        }
        product
    }

    fn transposed(&self, values: &DVector<f64>) -> DVector<f64> {
        let joints = self.widths.len();
        let values = DMatrix::from_column_slice(values.len() / joints, joints, values.as_slice());
        DVector::from_column_slice(self.sampled.values.tr_mul(&values).as_slice())
    }

    /// The Hessian of the energy for a constant metric, relative to the energy.
    fn first_hessian(&self, x: &DVector<f64>) -> Option<DMatrix<f64>> {
        let stroke = self.stroke(&self.coefficients(x))?;
        let metric = stroke.mean_metric();
        let functions = self.sampled.series.functions();
        // Integrals of products of rates are diagonal: all functions are orthogonal.
        let stiffness = |k: usize| {
            let slopes = self.sampled.slopes.column(k).norm_squared();
            let points = self.sampled.slopes.nrows() as f64;
            match slopes > 0.0 {
                true => 2.0 * slopes / points,
                // The mean does not change the energy directly; it may move as the first harmonic.
                false => 4.0 * std::f64::consts::PI.powi(2),
            }
        };
        let size = functions * self.widths.len();
        Some(DMatrix::from_fn(size, size, |i, j| {
            match i % functions == j % functions {
                false => 0.0,
                true => {
                    let (a, b) = (i / functions, j / functions);
                    self.widths[a] * self.widths[b] * metric[(a, b)] * stiffness(i % functions)
                        / stroke.totals.energy
                }
            }
        }))
    }
}

/// Smallest and largest value of each joint on a fine grid of times.
fn ranges(series: &Series, coefficients: &[f64]) -> Vec<(f64, f64)> {
    let count = CHECKS_PER_TERM * series.terms();
    let mut ranges: Vec<(f64, f64)> = Vec::new();
    for k in 0..count {
        let shape = series.shape(coefficients, k as f64 / count as f64);
        ranges.resize(shape.len(), (f64::INFINITY, f64::NEG_INFINITY));
        for (range, x) in ranges.iter_mut().zip(shape) {
            *range = (range.0.min(x), range.1.max(x));
        }
    }
    ranges
}

/// The stroke made smaller until it is strictly inside the limits, except at a fixed start.
pub fn inside(series: &Series, coefficients: &[f64], limits: &[(f64, f64)]) -> Option<Vec<f64>> {
    const SHRINK: f64 = 0.995;
    const ROUNDS: usize = 400;
    let functions = series.functions();
    let has_mean = matches!(series, Series::Closed { .. });
    let mut coefficients = coefficients.to_vec();
    for _ in 0..ROUNDS {
        let is_inside = |(range, limit): (&(f64, f64), &(f64, f64))| match has_mean {
            true => limit.0 < range.0 && range.1 < limit.1,
            false => limit.0 <= range.0 && range.1 <= limit.1,
        };
        if ranges(series, &coefficients)
            .iter()
            .zip(limits)
            .all(is_inside)
        {
            return Some(coefficients);
        }
        for (joint, c) in coefficients.chunks_mut(functions).enumerate() {
            let middle = 0.5 * (limits[joint].0 + limits[joint].1);
            for (k, c) in c.iter_mut().enumerate() {
                match has_mean && k == 0 {
                    true => *c = middle + SHRINK * (*c - middle),
                    false => *c *= SHRINK,
                }
            }
        }
    }
    None
}
