//! The best stroke of one series from one start.

use models::ShapeGeometry;
use nalgebra::{DMatrix, DVector};

use super::bounds::Bounds;
use super::evaluation::{Evaluation, Problem};
use super::interior_point::{Minimum, minimise};
use super::objective::{Objective, WithDerivatives};
use super::stroke_path::{SampledSeries, Series};
use super::totals::Stroke;

/// An objective as a function of the coefficients of a series.
pub struct StrokeProblem<'a> {
    geometry: &'a ShapeGeometry,
    objective: &'a dyn Objective,
    sampled: SampledSeries,
    /// Widths of the ranges of the joints, by which coefficients and rows are scaled.
    widths: Vec<f64>,
}

impl<'a> StrokeProblem<'a> {
    /// The problem for a series.
    pub fn new(
        geometry: &'a ShapeGeometry,
        objective: &'a dyn Objective,
        series: Series,
        limits: &[(f64, f64)],
    ) -> Self {
        Self {
            geometry,
            objective,
            widths: limits.iter().map(|r| r.1 - r.0).collect(),
            sampled: SampledSeries::new(series),
        }
    }

    /// The best stroke from one with these coefficients, inside `limits`.
    pub fn solve(
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
            self.scaled(coefficients),
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
        let functions = self.sampled.series.functions();
        (x.iter().enumerate())
            .map(|(k, x)| x * self.widths[k / functions])
            .collect()
    }

    fn scaled(&self, coefficients: &[f64]) -> DVector<f64> {
        let functions = self.sampled.series.functions();
        let scaled = coefficients.iter().enumerate();
        DVector::from_iterator(
            coefficients.len(),
            scaled.map(|(k, c)| c / self.widths[k / functions]),
        )
    }

    fn gradient(&self, stroke: &Stroke, (_, weights): &WithDerivatives) -> DVector<f64> {
        let (of_shapes, of_rates) = stroke.derivatives(weights);
        let functions = self.sampled.series.functions();
        let gradient = self.sampled.to_coefficients(&of_shapes, &of_rates);
        let scaled = gradient.iter().enumerate();
        DVector::from_iterator(
            gradient.len(),
            scaled.map(|(k, g)| g * self.widths[k / functions]),
        )
    }
}

impl Problem for StrokeProblem<'_> {
    fn evaluate(&self, x: &DVector<f64>) -> Option<Evaluation> {
        let stroke = self.stroke(&self.coefficients(x))?;
        let cost = self.objective.cost(&stroke.totals);
        let condition = self.objective.condition(&stroke.totals);
        let evaluation = Evaluation {
            cost: cost.0,
            gradient: self.gradient(&stroke, &cost),
            condition: condition.map(|c| (c.0, self.gradient(&stroke, &c))),
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
