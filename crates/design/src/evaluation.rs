//! Functions of the interior-point method, and the values that have bounds.

use nalgebra::{DMatrix, DVector};

use super::bounds::{Bounds, Multipliers};

/// Functions to minimise, with derivatives.
pub trait Problem {
    /// The functions at a point; none where they are not defined.
    fn evaluate(&self, x: &DVector<f64>) -> Option<Evaluation>;

    /// Values that have bounds: `Φ x` without offset, for all rows.
    fn rows(&self, x: &DVector<f64>) -> DVector<f64>;

    /// `Φ^T diag(weights) Φ`.
    fn weighted_product(&self, weights: &DVector<f64>) -> DMatrix<f64>;

    /// `Φ^T values`.
    fn transposed(&self, values: &DVector<f64>) -> DVector<f64>;

    /// Symmetric positive definite approximation of the Hessian at a point.
    fn first_hessian(&self, x: &DVector<f64>) -> Option<DMatrix<f64>>;
}

/// Values and derivatives at a point.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// The function to minimise.
    pub cost: f64,
    /// Its gradient.
    pub gradient: DVector<f64>,
    /// The condition with its gradient.
    pub condition: Option<(f64, DVector<f64>)>,
    /// Quantities that must be positive, with their gradients as rows.
    pub positive: Option<(DVector<f64>, DMatrix<f64>)>,
}

impl Evaluation {
    /// Violation of the condition.
    pub fn violation(&self) -> f64 {
        self.condition
            .as_ref()
            .map_or(0.0, |(value, _)| value.abs())
    }

    /// The bounds, and the bound zero of each inequality.
    pub fn with_inequalities(&self, bounds: &Bounds) -> Bounds {
        let count = self.positive.as_ref().map_or(0, |(values, _)| values.len());
        let extended = |bounds: &DVector<f64>, value: f64| {
            bounds
                .clone()
                .resize_vertically(bounds.len() + count, value)
        };
        Bounds {
            lower: extended(&bounds.lower, 0.0),
            upper: extended(&bounds.upper, f64::INFINITY),
        }
    }

    /// Values that have bounds: linear functions, then inequalities.
    pub fn rows(&self, problem: &dyn Problem, x: &DVector<f64>) -> DVector<f64> {
        self.stacked(problem.rows(x), |(values, _)| values.clone())
    }

    /// Change of these values to first order.
    pub fn change_of_rows(&self, problem: &dyn Problem, change: &DVector<f64>) -> DVector<f64> {
        self.stacked(problem.rows(change), |(_, slopes)| slopes * change)
    }

    fn stacked(
        &self,
        linear: DVector<f64>,
        below: impl Fn(&(DVector<f64>, DMatrix<f64>)) -> DVector<f64>,
    ) -> DVector<f64> {
        let Some(positive) = &self.positive else {
            return linear;
        };
        let (top, below) = (linear.len(), below(positive));
        let mut stacked = linear.resize_vertically(top + below.len(), 0.0);
        stacked.rows_mut(top, below.len()).copy_from(&below);
        stacked
    }

    /// `J^T values` with the derivatives `J` of all rows.
    pub fn transposed(&self, problem: &dyn Problem, values: &DVector<f64>) -> DVector<f64> {
        let Some((_, slopes)) = &self.positive else {
            return problem.transposed(values);
        };
        let top = values.len() - slopes.nrows();
        problem.transposed(&values.rows(0, top).into_owned())
            + slopes.tr_mul(&values.rows(top, slopes.nrows()))
    }

    /// `J^T diag(weights) J` with the derivatives `J` of all rows.
    pub fn weighted_product(&self, problem: &dyn Problem, weights: &DVector<f64>) -> DMatrix<f64> {
        let Some((_, slopes)) = &self.positive else {
            return problem.weighted_product(weights);
        };
        let top = weights.len() - slopes.nrows();
        let mut weighted = slopes.clone();
        for (mut row, weight) in weighted
            .row_iter_mut()
            .zip(weights.rows(top, slopes.nrows()).iter())
        {
            row *= *weight;
        }
        // A product of matrices is several times as fast as `tr_mul`.
        problem.weighted_product(&weights.rows(0, top).into_owned()) + slopes.transpose() * weighted
    }

    /// Gradient of the Lagrangian, without linear functions, whose gradients are constant.
    pub fn lagrangian_gradient(&self, multiplier: f64, of_bounds: &Multipliers) -> DVector<f64> {
        let mut gradient = self.gradient.clone();
        if let Some((_, slope)) = &self.condition {
            gradient += multiplier * slope;
        }
        if let Some((_, slopes)) = &self.positive {
            let top = of_bounds.lower.len() - slopes.nrows();
            gradient -= slopes.tr_mul(&of_bounds.lower.rows(top, slopes.nrows()));
        }
        gradient
    }
}
