//! Functions of the interior-point method, the bounds of their values, distances from these and
//! multipliers.

use nalgebra::{DMatrix, DVector};

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

/// Fraction-to-boundary parameter: largest part of the distance to a bound that a step takes.
const TO_BOUND: f64 = 0.995;

/// Bounds of the rows, without their offset; infinite ones do not count.
pub struct Bounds {
    /// Lower bounds.
    pub lower: DVector<f64>,
    /// Upper bounds.
    pub upper: DVector<f64>,
}

/// Distances from the bounds.
pub struct Slacks {
    pub lower: DVector<f64>,
    pub upper: DVector<f64>,
}

/// Multipliers of the bounds.
pub struct Multipliers {
    pub lower: DVector<f64>,
    pub upper: DVector<f64>,
}

impl Slacks {
    /// None unless the rows are strictly inside the bounds.
    pub fn new(rows: &DVector<f64>, bounds: &Bounds) -> Option<Self> {
        let slacks = Self {
            lower: rows - &bounds.lower,
            upper: &bounds.upper - rows,
        };
        let is_inside = |s: &DVector<f64>| s.iter().all(|s| *s > 0.0);
        (is_inside(&slacks.lower) && is_inside(&slacks.upper)).then_some(slacks)
    }

    /// Sum of the logarithms.
    pub fn logarithms(&self) -> f64 {
        let all = self.lower.iter().chain(self.upper.iter());
        all.filter(|s| s.is_finite()).map(|s| s.ln()).sum()
    }

    /// Multipliers on the central path.
    pub fn multipliers(&self, barrier: f64) -> Multipliers {
        Multipliers {
            lower: self.lower.map(|s| barrier / s),
            upper: self.upper.map(|s| barrier / s),
        }
    }

    /// Longest step, of at most one, that stays inside the bounds.
    pub fn longest(&self, change: &DVector<f64>) -> f64 {
        let lower = self.lower.iter().zip(change.iter().map(|c| -c));
        let upper = self.upper.iter().zip(change.iter().copied());
        lower
            .chain(upper)
            .fold(1.0_f64, |longest, (s, c)| match c > 0.0 {
                true => longest.min(TO_BOUND * s / c),
                false => longest,
            })
    }

    /// Smallest distance from a bound, relative to the distance of both bounds of the row; of rows
    /// with two finite bounds.
    pub fn smallest_share(&self) -> f64 {
        let pairs = self.lower.iter().zip(self.upper.iter());
        let finite = pairs.filter(|(a, b)| a.is_finite() && b.is_finite());
        let shares = finite.map(|(a, b)| a.min(*b) / (a + b));
        shares.fold(f64::INFINITY, f64::min)
    }
}

impl Multipliers {
    /// Newton's step of the multipliers, kept near the central path.
    pub fn moved(&self, old: &Slacks, new: &Slacks, change: &DVector<f64>, barrier: f64) -> Self {
        // Multipliers may leave the central path by this factor (Waechter & Biegler 2006).
        const FREEDOM: f64 = 1e10;
        let moved = |z: &DVector<f64>, s: &DVector<f64>, new: &DVector<f64>, sign: f64| {
            let raw = DVector::from_fn(z.len(), |k, _| {
                barrier / s[k] - z[k] - z[k] / s[k] * sign * change[k]
            });
            let longest = (z.iter().zip(&raw)).fold(1.0_f64, |longest, (z, d)| match *d < 0.0 {
                true => longest.min(-TO_BOUND * z / d),
                false => longest,
            });
            DVector::from_fn(z.len(), |k, _| {
                let centre = barrier / new[k];
                (z[k] + longest * raw[k]).clamp(centre / FREEDOM, centre * FREEDOM)
            })
        };
        Self {
            lower: moved(&self.lower, &old.lower, &new.lower, 1.0),
            upper: moved(&self.upper, &old.upper, &new.upper, -1.0),
        }
    }
}
