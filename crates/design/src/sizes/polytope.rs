//! Points between linear bounds, and functions that are minimised there.

use nalgebra::{DMatrix, DVector};

use crate::evaluation::{Bounds, Evaluation, Problem, Slacks};
use crate::interior_point::{Minimum, minimise};

/// Points `y` with `lower <= row . y <= upper` for each row.
pub struct Polytope {
    rows: DMatrix<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

/// `cost + gradient . y + y . hessian y / 2`.
#[derive(Clone, Debug)]
pub struct Quadratic {
    pub cost: f64,
    pub gradient: DVector<f64>,
    pub hessian: DMatrix<f64>,
}

/// A predicted decrease, relative to the size of the function, at which a minimum is found.
const TOLERANCE: f64 = 1e-10;

/// Newton decrement at which the centre is found: its distances from the bounds are then known to
/// this relative accuracy.
const CENTRED: f64 = 1e-3;

/// Eigenvalue of a projection that counts as zero.
const ROUNDING: f64 = 1e-10;

/// Largest number of iterations; a quadratic function with bounds takes about 40.
const ITERATIONS: usize = 400;

impl Polytope {
    /// No bounds on `variables` numbers.
    pub fn new(variables: usize) -> Self {
        Self {
            rows: DMatrix::zeros(0, variables),
            lower: Vec::new(),
            upper: Vec::new(),
        }
    }

    /// Adds the bounds of a row.
    pub fn push(&mut self, row: DVector<f64>, lower: f64, upper: f64) {
        let count = self.rows.nrows();
        let rows = std::mem::replace(&mut self.rows, DMatrix::zeros(0, 0));
        self.rows = rows.insert_row(count, 0.0);
        self.rows.row_mut(count).copy_from(&row.transpose());
        self.lower.push(lower);
        self.upper.push(upper);
    }

    /// Radius of the largest ball about the origin inside the bounds; negative if it is outside.
    pub fn depth(&self) -> f64 {
        let rows = self.rows.row_iter().zip(self.lower.iter().zip(&self.upper));
        rows.map(|(row, (lower, upper))| upper.min(-lower) / row.norm())
            .fold(f64::INFINITY, f64::min)
    }

    /// The points whose balls of a radius are inside the bounds.
    pub fn shrunk(mut self, radius: f64) -> Self {
        for (k, row) in self.rows.row_iter().enumerate() {
            self.lower[k] += radius * row.norm();
            self.upper[k] -= radius * row.norm();
        }
        self
    }

    fn bounds(&self) -> Bounds {
        Bounds {
            lower: DVector::from_column_slice(&self.lower),
            upper: DVector::from_column_slice(&self.upper),
        }
    }

    /// The analytic centre, where the product of the distances from all bounds is largest; none if
    /// the origin is outside.
    pub fn centre(&self) -> Option<DVector<f64>> {
        let bounds = self.bounds();
        let mut y = DVector::zeros(self.rows.ncols());
        for _ in 0..ITERATIONS {
            let slacks = Slacks::new(&(&self.rows * &y), &bounds)?;
            let (lower, upper) = (slacks.lower.map(f64::recip), slacks.upper.map(f64::recip));
            let gradient = self.rows.tr_mul(&(&upper - &lower));
            let weights = lower.component_mul(&lower) + upper.component_mul(&upper);
            let hessian = self
                .rows
                .tr_mul(&(DMatrix::from_diagonal(&weights) * &self.rows));
            let step = hessian.cholesky()?.solve(&gradient);
            // With this step damped Newton's method stays inside (Nesterov & Nemirovskii 1994).
            let decrement = gradient.dot(&step).max(0.0).sqrt();
            y -= step / (1.0 + decrement);
            if decrement < CENTRED {
                break;
            }
        }
        Some(y)
    }

    /// Orthonormal changes that keep all bounds that are nearer than `near`, one per column.
    pub fn free_directions(&self, near: f64) -> DMatrix<f64> {
        let variables = self.rows.ncols();
        let mut active = DMatrix::zeros(variables, variables);
        let rows = self.rows.row_iter().zip(self.lower.iter().zip(&self.upper));
        for (row, (lower, upper)) in rows {
            let row = row.transpose();
            if upper.min(-lower) < near * row.norm() {
                active += &row * row.transpose() / row.norm_squared();
            }
        }
        // The eigenvalue is zero for free directions up to rounding, and at least of the order of
        // the squared sine between two active rows for the others.
        let eigen = active.symmetric_eigen();
        let free = (0..variables).filter(|&k| eigen.eigenvalues[k] < ROUNDING);
        let columns: Vec<DVector<f64>> = free
            .map(|k| eigen.eigenvectors.column(k).into_owned())
            .collect();
        match columns.is_empty() {
            true => DMatrix::zeros(variables, 0),
            false => DMatrix::from_columns(&columns),
        }
    }

    /// Minimum of a quadratic function from a point inside; none if the point is outside.
    pub fn minimum(&self, function: &Quadratic, start: &DVector<f64>) -> Option<Minimum> {
        let problem = Bounded {
            rows: &self.rows,
            function,
        };
        minimise(
            &problem,
            &self.bounds(),
            start.clone(),
            TOLERANCE,
            ITERATIONS,
        )
    }
}

impl Quadratic {
    /// Half of the square of the distance from the origin.
    pub fn distance(variables: usize) -> Self {
        Self {
            cost: 0.0,
            gradient: DVector::zeros(variables),
            hessian: DMatrix::identity(variables, variables),
        }
    }

    /// The function at a point.
    pub fn at(&self, y: &DVector<f64>) -> f64 {
        self.cost + self.gradient.dot(y) + 0.5 * y.dot(&(&self.hessian * y))
    }

    /// The function interpolated at the points of [`stencil`] in the same order.
    pub fn through(values: &[f64], variables: usize, step: f64) -> Self {
        let cost = values[0];
        let single = |k: usize| (values[1 + 2 * k], values[2 + 2 * k]);
        let gradient = DVector::from_fn(variables, |k, _| {
            let (above, below) = single(k);
            (above - below) / (2.0 * step)
        });
        let mut hessian = DMatrix::from_fn(variables, variables, |i, j| {
            let (above, below) = single(i);
            match i == j {
                true => (above - 2.0 * cost + below) / (step * step),
                false => 0.0,
            }
        });
        let mut next = 1 + 2 * variables;
        for i in 0..variables {
            for j in 0..i {
                let both = values[next];
                next += 1;
                let expected = cost
                    + step * (gradient[i] + gradient[j])
                    + 0.5 * step * step * (hessian[(i, i)] + hessian[(j, j)]);
                let mixed = (both - expected) / (step * step);
                hessian[(i, j)] = mixed;
                hessian[(j, i)] = mixed;
            }
        }
        Self {
            cost,
            gradient,
            hessian,
        }
    }
}

/// The points at which a quadratic function is interpolated: the origin, one step forwards and
/// backwards along each axis, and one step along both axes of each pair.
pub fn stencil(variables: usize, step: f64) -> Vec<DVector<f64>> {
    let unit = |k: usize| DVector::from_fn(variables, |i, _| if i == k { step } else { 0.0 });
    let mut points = vec![DVector::zeros(variables)];
    for k in 0..variables {
        points.extend([unit(k), -unit(k)]);
    }
    for i in 0..variables {
        points.extend((0..i).map(|j| unit(i) + unit(j)));
    }
    points
}

/// Distance of the points of [`stencil`] from the origin, relative to the step.
pub const STENCIL_RADIUS: f64 = std::f64::consts::SQRT_2;

struct Bounded<'a> {
    rows: &'a DMatrix<f64>,
    function: &'a Quadratic,
}

impl Problem for Bounded<'_> {
    fn evaluate(&self, y: &DVector<f64>) -> Option<Evaluation> {
        let cost = self.function.at(y);
        cost.is_finite().then(|| Evaluation {
            cost,
            gradient: &self.function.gradient + &self.function.hessian * y,
            condition: None,
            positive: None,
        })
    }

    fn rows(&self, y: &DVector<f64>) -> DVector<f64> {
        self.rows * y
    }

    fn weighted_product(&self, weights: &DVector<f64>) -> DMatrix<f64> {
        self.rows
            .tr_mul(&(DMatrix::from_diagonal(weights) * self.rows))
    }

    fn transposed(&self, values: &DVector<f64>) -> DVector<f64> {
        self.rows.tr_mul(values)
    }

    /// The Hessian with the absolute values of its eigenvalues.
    fn first_hessian(&self, _: &DVector<f64>) -> Option<DMatrix<f64>> {
        let eigen = self.function.hessian.clone().symmetric_eigen();
        let largest = eigen.eigenvalues.amax().max(f64::MIN_POSITIVE);
        // Curvatures below rounding would leave the matrix singular.
        let values = eigen.eigenvalues.map(|e| e.abs().max(1e-8 * largest));
        let vectors = &eigen.eigenvectors;
        Some(vectors * DMatrix::from_diagonal(&values) * vectors.transpose())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadratic_functions_are_interpolated_and_minimised_between_bounds() {
        let exact = Quadratic {
            cost: 2.0,
            gradient: DVector::from_vec(vec![1.0, -3.0, 0.5]),
            hessian: DMatrix::from_row_slice(3, 3, &[2.0, 0.5, 0.1, 0.5, -1.0, 0.3, 0.1, 0.3, 4.0]),
        };
        let points = stencil(3, 0.1);
        let values: Vec<f64> = points.iter().map(|y| exact.at(y)).collect();
        let found = Quadratic::through(&values, 3, 0.1);
        assert!((found.gradient - &exact.gradient).amax() < 1e-12);
        assert!((found.hessian - &exact.hessian).amax() < 1e-11);
        let farthest = points.iter().fold(0.0_f64, |r, y| r.max(y.norm()));
        assert!((farthest - 0.1 * STENCIL_RADIUS).abs() < 1e-15);
        // The function is concave along the second axis: its minimum is at the bound there.
        let mut cube = Polytope::new(3);
        for k in 0..3 {
            let row = DVector::from_fn(3, |i, _| f64::from(u8::from(i == k)));
            cube.push(row, -1.0, 2.0);
        }
        assert_eq!(cube.depth(), 1.0);
        let minimum = cube.minimum(&exact, &DVector::zeros(3)).unwrap();
        // The gradient vanishes along the others, or they are at their bounds.
        assert!((minimum.x[1] - 2.0).abs() < 1e-6, "{}", minimum.x);
        let slope = &exact.gradient + &exact.hessian * &minimum.x;
        for k in [0, 2] {
            let is_at_bound = (minimum.x[k] + 1.0).abs() < 1e-6 && slope[k] > 0.0;
            assert!(slope[k].abs() < 1e-4 || is_at_bound, "{k} {}", minimum.x);
        }
    }
}
